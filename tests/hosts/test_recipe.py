# SPDX-License-Identifier: Apache-2.0
"""Values back out of scripts, and into a scene file: only the lights' strengths change, and they change right."""
import difflib
import json
import os
import subprocess
import unittest

import shots
from shots import SHOTS, np, support

# As somebody might have written it: odd blanks, exponents, an escape, a light without a colour.
SCENE = r'''{ "caustics_scene" : 1,
  "materials": {"power_w": {"type": "diffuse", "color": [0.5, 5e-1, 0.50]}},
  "world": {"color": [0.1, 0.2, 0.3]},
  "lights": [
    {"name": "Key \"light\" {1}", "type": "area", "group": "key", "shape": "rectangle", "size": [ 0.30, 3.0E-1 ],
       "power_w":1.20e2  ,"look": {"from": [2, 1.5, 3], "to": [0, 0, 0.5]}},
    {"power_w": 7, "name": "Key.002", "type": "point", "group": "key",
     "color": [1, 0.5, 0.25]},
    {"name": "Rim", "type": "sun", "strength": 3, "angle_deg": 0.5},
    {"name": "Left alone", "type": "spot", "power_w": 0.10000000000000001, "cone_deg": 40}
  ],
  "camera": {"strength": 1.10, "filter": {"type": "box", "width": 1}}
}
'''


class Recipe(shots.Shot):
    def write(self, lights, name="recipe.json"):
        support.write_text(self.path(name), json.dumps({"caustics_recipe": 1, "lights": lights}))
        return self.path(name)

    def to_scene(self, lights, text=SCENE):
        support.write_text(self.path("scene.json"), text)
        self.run_merge("recipe", "--recipe", self.write(lights), "--to-scene", self.path("scene.json"))
        return support.read_bytes(self.path("scene.json")).decode()

    def test_scripts_give_the_recipe_back(self):
        for name in SHOTS:
            if name == "negative_tint":
                continue
            with self.subTest(name):
                _, wanted = self.shot(name)
                self.run_merge("nuke", self.path("out.exr"), "-o", self.path("s.nk"))
                self.run_merge("blender", self.path("out.exr"), "-o", self.path("s.py"))
                recipes = [self.run_merge("recipe", *w).stdout for w in (("--from-nuke", self.path("s.nk")),
                                                                        ("--from-blender", self.path("s.py")))]
                self.assertEqual(json.loads(recipes[0]), json.loads(recipes[1]))
                support.write_text(self.path("r.json"), recipes[0])
                keep = [w for o in ("--albedo",) if o in SHOTS[name][1]
                        for w in SHOTS[name][1][SHOTS[name][1].index(o):][:2]]
                self.run_merge("add", self.path("beauty.exr"), self.path("caustics.exr"), "-o", self.path("again.exr"), "--recipe",
                               self.path("r.json"), *keep)
                prefix = "ViewLayer.Combined" if SHOTS[name][0] in ("multilayer", "albedo") else ""
                self.assertTrue(np.array_equal(self.result("again.exr", prefix), wanted))

    def test_scene_only_the_lights_change(self):
        text = self.to_scene({"key": {"ev": 1, "tint": [1, 0.8, 0.5]}, "Rim": {"gain": 0.1}})
        changes = [d for d in difflib.ndiff(SCENE.splitlines(), text.splitlines()) if d[0] in "+-"]
        self.assertEqual([c[2:].strip() for c in changes if c[0] == "+"], [
            '"power_w":240, "color": [1, 0.8, 0.5]  ,"look": {"from": [2, 1.5, 3], "to": [0, 0, 0.5]}},',
            '{"power_w": 14, "name": "Key.002", "type": "point", "group": "key",',
            '"color": [1, 0.4, 0.125]},',
            '{"name": "Rim", "type": "sun", "strength": 0.30000000000000004, "angle_deg": 0.5},'])
        old, new = json.loads(SCENE), json.loads(text)
        for light in new["lights"][:3]:
            light.pop("power_w", 0), light.pop("color", 0), light.pop("strength", 0)
        for light in old["lights"][:3]:
            light.pop("power_w", 0), light.pop("color", 0), light.pop("strength", 0)
        self.assertEqual(old, new)

    def test_scene_identity_is_byte_for_byte(self):
        self.assertEqual(self.to_scene({"key": {"ev": 0}, "caustics_Rim": {}, "key_ind": {"gain": 1}}), SCENE)

    def test_scene_mute_solo_world(self):
        lights = json.loads(self.to_scene({"key": {"mute": True}}))["lights"]
        self.assertEqual([lights[0]["power_w"], lights[1]["power_w"], lights[2]["strength"]], [0, 0, 3])
        scene = json.loads(self.to_scene({"key": {"ev": 2}, "Rim": {"solo": True, "ev": 1}, "world": {}}))
        self.assertEqual([scene["lights"][0]["power_w"], scene["lights"][2]["strength"], scene["world"]["strength"]], [0, 6, 0])
        scene = json.loads(self.to_scene({"world": {"gain": 4, "tint": [1, 2, 0]}}))
        self.assertEqual(scene["world"], {"strength": 4, "color": [0.1, 0.4, 0]})

    def test_names(self):
        """The original name, the layer's, and the layer's without its prefix."""
        for name in ("Left alone", "Left_alone", "caustics_Left_alone"):
            self.assertEqual(json.loads(self.to_scene({name: {"gain": 2}}))["lights"][3]["power_w"], 0.2)

    def refuse_scene(self, lights, says, text=SCENE):
        support.write_text(self.path("scene.json"), text)
        recipe = self.write(lights)
        self.refused("recipe", "--recipe", recipe, "--to-scene", self.path("scene.json"), says=says)
        self.assertEqual(support.read_bytes(self.path("scene.json")).decode(), text)

    def test_scene_refusals(self):
        self.refuse_scene({"kee": {}}, 'did you mean "key"')
        self.refuse_scene({"key": {"gain": -1}}, "negative")
        self.refuse_scene({"key": {"ev": 2000}}, "infinite")
        self.refuse_scene({"key_ind": {"gain": 2}}, "indirect layer alone")
        self.refuse_scene({"key": {}}, "line 1", text="{\"caustics_scene\": 1,")
        self.refuse_scene({"key": {}}, "no scene", text="{}")
        self.refuse_scene({"key": {"gain": 2}}, "escapes", text=SCENE.replace('"power_w":1.20e2', r'"p\u006fwer_w":1.20e2'))
        self.refuse_scene({"key": {"dim": 2}}, 'unknown key "dim"')
        self.refuse_scene({"key": {"tint": [1, 2, 3]}}, "texture", text=SCENE.replace("[1, 0.5, 0.25]", '{"image": "x.exr"}'))

    def test_scene_is_atomic(self):
        """Refused, the folder is read-only: the old file is whole."""
        support.write_text(self.path("scene.json"), SCENE)
        link = self.path("link.json")
        os.symlink("scene.json", link)
        self.run_merge("recipe", "--recipe", self.write({"key": {"gain": 2}}), "--to-scene", link)
        self.assertEqual(support.read_bytes(self.path("scene.json")).decode(), SCENE, "a link is replaced, not followed")
        self.assertFalse(os.path.islink(link))

    def test_saved_by_nuke(self):
        """What else a saved file holds: other nodes, quotes, braces, several lines, a second tab."""
        self.shot("plain")
        self.run_merge("nuke", self.path("out.exr"), "-o", self.path("s.nk"))
        wanted = self.run_merge("recipe", "--from-nuke", self.path("s.nk")).stdout
        text = support.read_bytes(self.path("s.nk")).decode()
        noise = ('Root {\n inputs 0\n name "/a b/{x.nk"\n onScriptLoad "def f():\\n  return \\{\\}\\n"\n}\n'
                 'NoOp {\n inputs 0\n name Other\n addUserKnob {20 User}\n addUserKnob {7 caustics_key_ev}\n caustics_key_ev 9\n}\n'
                 'Grade {\n inputs 0\n white {1 2\n   3 4}\n name Grade1\n}\n')
        saved = noise + text.replace(" name CausticsRelight\n", " name MyRelight\n selected true\n xpos -12\n knobChanged \"a {\\\"b\\\"\"\n", 1)
        support.write_text(self.path("saved.nk"), saved)
        self.assertEqual(self.run_merge("recipe", "--from-nuke", self.path("saved.nk")).stdout, wanted)
        for value in ("{{curve x1 0 x24 2}}", "{{\"frame/24\"}}", "{1 2}", "nan", ""):
            support.write_text(self.path("bad.nk"), text.replace("caustics_key_ev 1.25", f"caustics_key_ev {value}"))
            self.refused("recipe", "--from-nuke", self.path("bad.nk"), says='light "key": its ev is animated')
        support.write_text(self.path("bad.nk"), text + text)
        self.refused("recipe", "--from-nuke", self.path("bad.nk"), says="2 relight panels")
        support.write_text(self.path("bad.nk"), noise)
        self.refused("recipe", "--from-nuke", self.path("bad.nk"), says="no relight panel")
        for cut in range(0, len(text), 97):  # cut short: refused or read, never a crash
            support.write_text(self.path("cut.nk"), text[:cut])
            self.assertIn(self.cut(), (0, 1))

    def cut(self):
        return subprocess.run([support.MERGE, "recipe", "--from-nuke", self.path("cut.nk")], capture_output=True, check=False).returncode

    def test_usage(self):
        self.refused("recipe", says="one of --from-nuke", expect=2)
        self.refused("recipe", "--from-nuke", "a", "--from-blender", "b", says="one of --from-nuke", expect=2)
        self.refused("recipe", "--from-nuke", self.path("none.nk"), says="none.nk")
        support.write_text(self.path("x.py"), "print(1)\n")
        self.refused("recipe", "--from-blender", self.path("x.py"), says="neither a Blender file nor a script")


if __name__ == "__main__":
    unittest.main()
