# SPDX-License-Identifier: Apache-2.0
# Runs in Blender, on an open file: prints the sliders' values as a recipe.
import json
import struct

import bpy

MARK = "caustics_relight"


def short(value):
    """The shortest decimal that is this float."""
    for digits in range(6, 10):
        number = float(f"{value:.{digits}g}")
        if struct.pack("<f", number) == struct.pack("<f", value):
            return number
    return value


def trees():
    for scene in bpy.data.scenes:
        tree = getattr(scene, "compositing_node_group", None) or getattr(scene, "node_tree", None)
        if tree:
            yield tree


def panels():
    """Group nodes that our script made, in any scene's compositor, with the tree that holds each."""
    seen, left = set(), list(trees())
    while left:
        tree = left.pop()
        if tree.name in seen:
            continue
        seen.add(tree.name)
        for node in tree.nodes:
            inner = getattr(node, "node_tree", None)
            if inner and inner.get(MARK):
                yield tree, node
            elif inner:
                left.append(inner)


def animated(tree, node):
    data = tree.animation_data
    paths = [d.data_path for d in data.drivers] if data else []
    if data and data.action:
        paths += [c.data_path for c in getattr(data.action, "fcurves", [])]
    return any(f'nodes["{node.name}"].inputs' in path for path in paths)


def recipe(node):
    lights, made = {}, json.loads(node.node_tree[MARK])
    for label in made["lights"]:
        def value(name):
            socket = node.inputs[f"{label} {name}"]
            if socket.is_linked:
                raise ValueError(f'light "{label}": its {name} is linked, and a recipe holds one value')
            return socket.default_value
        lights[label] = {"gain": short(value("gain")), "ev": short(value("EV")),
                         "tint": [short(c) for c in value("tint")[:3]],
                         "mute": value("mute") > 0.5, "solo": value("solo") > 0.5}
        if f"{label} saturation" in node.inputs:
            lights[label]["saturation"] = short(value("saturation"))
    space = {"tint_space": made["tint_space"]} if made["tint_space"] else {}
    return {"caustics_recipe": 1, **space, "lights": lights}


def answer():
    found = list(panels())
    if len(found) != 1:
        return "CAUSTICS_ERROR " + (f"it has {len(found)} relight groups, and a recipe holds one" if found else
                                    "it has no relight group: the script of caustic-merge blender makes one")
    if animated(*found[0]):
        return "CAUSTICS_ERROR a slider of the relight group is animated, and a recipe holds one value"
    try:
        return "CAUSTICS_RECIPE " + json.dumps(recipe(found[0][1]))
    except (ValueError, KeyError) as problem:
        return f"CAUSTICS_ERROR {problem}"


print(answer(), flush=True)
