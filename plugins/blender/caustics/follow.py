# SPDX-License-Identifier: Apache-2.0
"""Drivers that let a light's gain in the compositor follow the light's own strength: light adds up, so a lamp that is made
brighter needs no new photons. Relative to what it had when its caustics were made."""
import json
import subprocess

import bpy

from . import programs

GROUP = "Caustics Relight"  # the node of caustic-merge's script


def labels(path):
    """{light or light group: its name on the sliders} of a file of layers."""
    run = subprocess.run([programs.find("caustic-merge"), "list", path, "--json"], env=programs.environment(), capture_output=True, text=True)
    lights = json.loads(run.stdout)["lights"] if run.returncode == 0 else []
    return {light["name"]: light["layers"]["radiance"].removeprefix("caustics_") for light in lights if "radiance" in light["layers"]}


def drive(job, tree):
    """Drives what can be driven in a compositor tree. Returns a line for each light that stays as it is."""
    node = tree.nodes.get(GROUP)
    named, notes = labels(job.caustics), []
    for group, lamps in job.extract.strengths.items():
        gain = node.inputs.get(f"{named.get(group, group)} gain") if node else None
        if gain is None:
            continue
        data = next((d for d in bpy.data.lights if d.name_full in lamps), None)
        if len(lamps) > 1 or data is None:
            notes.append(f'Light group "{group}": its gain follows no strength, as it has {len(lamps)} lamps')
            continue
        energy, exposure = lamps[data.name_full]
        if energy <= 0:
            notes.append(f'Light "{group}": its gain follows no strength, as that was {energy:g}')
            continue
        drive_one(gain, data, energy, exposure)
    return notes


def drive_one(gain, data, energy, exposure):
    gain.driver_remove("default_value")
    driver = gain.driver_add("default_value").driver
    driver.type = "SCRIPTED"
    terms = [("energy", "energy")] + [("exposure", "exposure")] * hasattr(data, "exposure")
    for name, path in terms:
        variable = driver.variables.new()
        variable.name, variable.type = name, "SINGLE_PROP"
        target = variable.targets[0]
        target.id_type, target.id, target.data_path = "LIGHT", data, path
    driver.expression = f"energy / {energy!r}" + (f" * pow(2, exposure - {exposure!r})" if len(terms) > 1 else "")
