# SPDX-License-Identifier: Apache-2.0
"""What both tests here share: a small scene with three lights, rendered with every kind of layer."""
import json
import os
import subprocess
import sys

try:
    import numpy as np
    import OpenImageIO as oiio
except ImportError:
    print("not run: this Python has no numpy or OpenImageIO")
    sys.exit(77)

SOURCE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PROGRAM = os.environ.get("CAUSTIC_RENDER", os.path.join(SOURCE, "build", "bin", "caustic-render"))
WIDTH, HEIGHT = 32, 18
LONG = "The lamp that hangs over the kitchen table"


def area(name, place, **more):
    return {"name": name, "type": "area", "shape": "rectangle", "size": [0.3, 0.3], "power_w": 50,
            "look": {"from": place, "to": [0, 0, 0]}, **more}


SCENE = {
    "caustics_scene": 1,
    "camera": {"type": "perspective", "look": {"from": [0, -3, 2], "to": [0, 0, 0.3]}, "hfov_deg": 40,
               "resolution": [WIDTH, HEIGHT], "filter": {"type": "box", "width": 1}},
    "materials": {"floor": {"type": "diffuse", "color": [0.7, 0.6, 0.5]},
                  "glass": {"type": "glass", "color": [1, 1, 1], "ior": 1.5}},
    "objects": [{"name": "Floor", "shape": {"type": "plane", "size": [4, 4]}, "material": "floor"},
                {"name": "Ball", "shape": {"type": "sphere", "radius": 0.4}, "position": [0, 0, 0.5],
                 "material": "glass"}],
    "lights": [area("Key light", [1, 1, 3]), area("Fill", [-1, -1, 2], group="warm"), area(LONG, [0, 1, 2])],
}
# What an artist sees, by light. The long name ends in a hash that the header tells.
SUFFIXES = ("", "_ind", "_E", "_S", "_err", "_ind_err")
NAMED = [f"caustics_{light}{s}" for light in ("Key_light", "warm") for s in SUFFIXES]


def render(folder, name, *options):
    scene, out = os.path.join(folder, "scene.json"), os.path.join(folder, name)
    with open(scene, "w", encoding="utf-8") as file:
        json.dump(SCENE, file)
    subprocess.run([PROGRAM, scene, "-o", out, "--photons", "4800", "--effects", "direct,indirect", "--layers",
                    "radiance,indirect,irradiance,error", "--quiet", *options], check=True)
    return out


def read(path):
    """Channels of all parts by name, and the attributes of the first part."""
    planes, attributes, part, file = {}, {}, 0, oiio.ImageInput.open(path)
    while file.seek_subimage(part, 0):
        spec = file.spec()
        if part == 0:
            attributes = {a.name: a.value for a in spec.extra_attribs}
        pixels = file.read_image(part, 0, 0, spec.nchannels, "float")
        planes.update({name: pixels[:, :, i] for i, name in enumerate(spec.channelnames)})
        part += 1
    file.close()
    return planes, attributes


class Check:
    def __init__(self):
        self.wrong = 0

    def that(self, ok, text):
        print(("ok    " if ok else "WRONG ") + text)
        self.wrong += not ok

    def end(self):
        sys.exit(1 if self.wrong else 0)


__all__ = ["Check", "HEIGHT", "LONG", "NAMED", "SUFFIXES", "WIDTH", "np", "read", "render"]
