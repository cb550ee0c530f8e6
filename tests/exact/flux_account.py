# SPDX-License-Identifier: Apache-2.0
"""Where the light went: each light's account closes, little is dropped, and what landed is what the film shows.

Direct: emitted = landed + straight + absorbed + escaped + cut + bent + dropped. Indirect: light goes on after a receiver, so
landed and straight are no part of the sum."""
import math
import os

import numpy as np

from rig import SOURCE, Check, Figure, ball, box, down_camera, plane, run, scene, sun

SCENES = ["a_ball_sun5", "b_ring", "c_water", "d_wineglass", "still_life", "aquarium", "pool", "plastic_room"]


def account(check, name, flux, indirect):
    parts = ["absorbed_w", "escaped_w", "cut_w", "bent_w", "dropped_w"] + ([] if indirect else ["landed_w", "straight_w"])
    emitted, total = flux["emitted_w"], sum(flux[p] for p in parts)
    if emitted == 0:
        return
    gap, dropped = total / emitted - 1, flux["dropped_w"] / emitted
    kind = "indirect" if indirect else "direct"
    check.that(abs(gap) <= 1e-4, f"{name}, {kind}: the account closes, gap {gap:.1e}")
    check.that(dropped <= 1e-3, f"{name}, {kind}: dropped {dropped:.1e} of what was emitted (balance of the roulette included)")
    check.that(flux["non_finite"] == 0, f"{name}, {kind}: no deposit was refused as not finite")


def bundled(check, photons):
    for name in SCENES:
        r = run(os.path.join(SOURCE, "scenes", name + ".json"), "--photons", photons, "--resolution", "48x27",
                "--effects", "direct,indirect", "--estimator", "P")
        for light in r.report["lights"]:
            account(check, f"{name}/{light['light']}", light["flux_direct"], False)
            account(check, f"{name}/{light['light']}", light["flux_indirect"], True)
            if "flux_direct_bent" in light:  # what starts at bent normals
                account(check, f"{name}/{light['light']}, bent", light["flux_direct_bent"], False)
                account(check, f"{name}/{light['light']}, bent", light["flux_indirect_bent"], True)


def landed(check, photons):
    """Cameras that see the whole receiver and nothing else: pi times the mean radiance times the area."""
    lamp = {"name": "Sun", "type": "point", "power_w": 10, "radius_m": 0.1, "look": {"from": [0.5, 0, 2.5], "to": [0, 0, 0]}}
    below_ball = [plane("Floor", [4, 4], [0, 0, 0]), ball("Ball", 0.5, [0, 0, 0.7])]
    tube = {"name": "Tube", "shape": {"type": "cylinder", "radius": 1, "height": 0.5}, "position": [0, 0, 0.01],
            "material": "mirror"}
    cases = {
        "glass ball, sun": (down_camera(0, 0, 0.1, 4, [96, 96]), below_ball, sun([0.3, 0, -1], 2)),
        "glass ball, lamp": (down_camera(0, 0, 0.1, 4, [96, 96]), below_ball, lamp),
        "mirror tube, sun": (down_camera(0, 0, 3, 4, [96, 96]), [plane("Floor", [4, 4], [0, 0, 0]), tube], sun([1, 0, -1])),
        "glass box, sun of 20 degrees": (down_camera(0, 0, 0.1, 4, [96, 96]),
                                         [plane("Floor", [4, 4], [0, 0, 0]), box("Box", [1, 1, 0.4], [0, 0, 0.5], "glass")],
                                         sun([0, 0.4, -1], 2, 20)),
    }
    for name, (camera, objects, light) in cases.items():
        ratios = []
        for seed in range(1, 7):
            r = run(scene(camera, objects, [light]), "--estimator", "P", "--photons", photons, "--seed", seed,
                    "--effects", "direct", "--layers", "radiance,irradiance")
            flux = r.light()["flux_direct"]
            ratios.append(r["caustics_Sun_E"][:, :, 1].mean() * 16 / flux["landed_w"])
            if seed > 1:
                continue
            account(check, name, flux, False)
            e, l = r["caustics_Sun_E"][:, :, 1], math.pi * r["caustics_Sun"][:, :, 1]
            check.that(np.allclose(e, l, rtol=1e-5, atol=1e-7), f"{name}: irradiance is pi times radiance over albedo 1")
        check.close(f"{name}: film's integral of E dA over what landed", Figure(ratios), 1.0, bias=0.003, sharp=0.003)


if __name__ == "__main__":
    found = Check()
    effort = float(os.environ.get("EFFORT", "1"))
    bundled(found, int(60000 * effort))
    landed(found, int(100000 * effort))
    found.end()
