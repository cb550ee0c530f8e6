# SPDX-License-Identifier: Apache-2.0
"""What is read from Blender scenes, against the scene files that they were built from and against explicit geometry."""
import math
import os
import sys
import types
import unittest

import bpy
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from support import Case, built, caustics, np, read_ply, run, world_triangles  # noqa: E402

import blender_scenes  # noqa: E402

from caustics import meshes  # noqa: E402

NEW = bpy.app.version >= (4, 0, 0)


class Files(Case):
    def test_round_trip(self):
        """Scene file -> Blender -> scene file: camera, lights, materials, placement."""
        for name in ("a_ball", "b_ring", "d_wineglass", "aquarium"):
            with self.subTest(name=name):
                self.new()
                path = os.path.join(os.path.dirname(blender_scenes.__file__), name + ".json")
                scene, doc = blender_scenes.build(path, types.SimpleNamespace(groups=False))
                blender_scenes.settings(scene, doc, types.SimpleNamespace(spp=1, seed=0, mode="off", res=None, threads=2, half=False, multilayer=False))
                caustics.unregister()
                caustics.register()
                made = self.export(name).doc
                self.close(made["camera"]["hfov_deg"], doc["camera"]["hfov_deg"])
                self.close(made["camera"]["matrix"], blender_scenes.matrix_of(doc["camera"]))
                self.assertEqual(made["camera"]["resolution"], doc["camera"].get("resolution", [480, 270]))
                for b in doc["lights"]:
                    a, = [light for light in made["lights"] if light["name"] == b["name"]]
                    self.assertEqual(a["type"], b["type"])
                    self.close(a["matrix"], blender_scenes.matrix_of(b))
                    for key in ("strength", "angle_deg", "power_w", "size", "color", "spread_deg"):
                        if key in b:
                            dims = not NEW and key == "strength"  # by (half angle / 2)^2, for suns as small as these
                            self.close(a[key], b[key] * (1 - math.radians(b["angle_deg"] / 4) ** 2) if dims else b[key])
                for key, m in doc["materials"].items():
                    for value in set(m) - {"type"}:
                        if m["type"] in ("diffuse", "glass"):
                            self.close(made["materials"][key][value], m[value])

    def close(self, a, b):
        np.testing.assert_allclose(np.array(a, "f8"), np.array(b, "f8"), rtol=2e-6, atol=2e-6)


class Cameras(Case):
    def project(self, doc, point):
        """Pixel coordinates from the top left, as render/trace/camera.c has them."""
        cam = doc["camera"]
        (w, h), m = cam["resolution"], np.array(cam["matrix"])
        x, y, z = (np.linalg.inv(m) @ [*point, 1])[:3]
        tall = h / (w * cam["pixel_aspect"])
        if cam["type"] == "perspective":
            half = math.tan(math.radians(cam["hfov_deg"]) / 2)
            u, v = x / -z / (2 * half), y / -z / (2 * half)
        else:
            u, v = x / cam["ortho_width"], y / cam["ortho_width"]
        u, v = u - cam["shift"][0], v - cam["shift"][1]
        return np.array([(u + 0.5) * w, (0.5 - v / tall) * h])

    def test_against_blender(self):
        """Every sensor fit, both shapes of picture, shift, uneven pixels, percentage."""
        n = 0
        for fit in ("AUTO", "HORIZONTAL", "VERTICAL"):
            for size in ((96, 54), (54, 96)):
                for aspect in ((1, 1), (1.7, 1), (1, 2)):
                    for kind in ("PERSP", "ORTHO"):
                        scene = self.new()
                        built.table()
                        data = scene.camera.data
                        data.sensor_fit, data.type, data.shift_x, data.shift_y = fit, kind, 0.13, -0.07
                        data.sensor_width, data.sensor_height, data.lens = 36, 20, 40
                        r = scene.render
                        (r.resolution_x, r.resolution_y), r.resolution_percentage = (2 * s for s in size), 50
                        r.pixel_aspect_x, r.pixel_aspect_y = aspect
                        bpy.context.view_layer.update()
                        doc = self.export().doc
                        self.assertEqual(doc["camera"]["resolution"], list(size))
                        for point in ((0, 0, 0), (1, 0.5, 0.2), (-0.7, 1, 0.9)):
                            seen = world_to_camera_view(scene, scene.camera, Vector(point))
                            want = [seen.x * size[0], (1 - seen.y) * size[1]]
                            np.testing.assert_allclose(self.project(doc, point), want, atol=2e-3, err_msg=f"{fit} {size} {aspect} {kind}")
                            n += 1
        self.assertEqual(n, 108)

    def test_border(self):
        scene = self.new()
        built.table()
        r = scene.render
        r.use_border = True
        r.border_min_x, r.border_max_x, r.border_min_y, r.border_max_y = 0.25, 0.5, 0.0, 0.5
        self.assertEqual(self.export().region, (24, 27, 48, 54))

    def test_film(self):
        scene = self.new()
        built.table()
        c = scene.cycles
        c.film_exposure, c.pixel_filter_type, c.filter_width = 2.0, "GAUSSIAN", 2.5
        c.max_bounces, c.diffuse_bounces, c.glossy_bounces, c.transmission_bounces = 9, 3, 5, 7
        doc = self.export().doc
        self.assertEqual((doc["camera"]["exposure"], doc["camera"]["filter"]), (2.0, {"type": "gaussian", "width": 2.5}))
        self.assertEqual(doc["bounces"], {"total": 9, "diffuse": 3, "glossy": 5, "transmission": 7})

    def test_refused(self):
        scene = self.new()
        built.table()
        scene.camera.data.type = "PANO"
        self.refused("pano", self.export)
        scene.camera = None
        self.refused("no camera", self.export)


class Geometry(Case):
    def same(self, one, other):
        a, b = world_triangles(one), world_triangles(other)
        self.assertEqual(a.shape, b.shape)
        np.testing.assert_allclose(a, b, atol=3e-4)

    def test_instances(self):
        scene = self.new()
        built.instances(scene)
        made = self.export("one")
        self.assertEqual(len({o["file"] for o in made.doc["objects"]}), 2)  # one mesh for three places
        empties = [o for o in scene.objects if o.instance_type == "COLLECTION"]
        inner = bpy.data.collections["Pair"].objects[0]
        for e in empties:
            o = built.link("Copy", inner.data)
            o.matrix_world = e.matrix_world @ inner.matrix_world
            bpy.data.objects.remove(e)
        self.same(made, self.export("two"))

    def test_modifiers(self):
        """At render level: 2 subdivisions, where the viewport has none."""
        scene = self.new()
        built.modifiers(scene)
        made = self.export("one")
        o = scene.objects["Ball"]
        o.modifiers["Sub"].levels, o.modifiers["Off"].show_viewport = 2, False
        graph = bpy.context.evaluated_depsgraph_get()
        o.data = bpy.data.meshes.new_from_object(o.evaluated_get(graph), depsgraph=graph)
        o.modifiers.clear()
        self.same(made, self.export("two"))

    def test_negative(self):
        """A mirrored body keeps its front side: the volume that its faces enclose changes its sign with the matrix."""
        scene = self.new()
        built.negative(scene)
        made = self.export()
        ball, = [o for o in made.doc["objects"] if o["name"] == "Ball"]
        v, n, tri = read_ply(self.path("scene/" + ball["file"]))
        self.assertLess(np.linalg.det(ball["matrix"]), 0)
        self.assertGreater(np.einsum("ij,ij->i", v[tri[:, 0]], np.cross(v[tri[:, 1]], v[tri[:, 2]])).sum(), 0)
        np.testing.assert_allclose(n, v / np.linalg.norm(v, axis=1)[:, None], atol=0.02)

    def test_pointers(self):
        """Arrays by address and by foreach_get are the same."""
        self.new()
        built.table()
        for o in (bpy.data.objects["Ball"], bpy.data.objects["Floor"]):
            o.data.calc_loop_triangles()
            by = [meshes.read(o.data, pointers) for pointers in (True, False)]
            for name in ("co", "tri", "material", "smooth", "normals"):
                np.testing.assert_array_equal(getattr(by[0], name), getattr(by[1], name))
        self.assertIsNotNone(meshes.view(bpy.data.objects["Ball"].data.vertices, "f4", 3, lambda v: v.co))
        self.assertIsNone(meshes.view(bpy.data.objects["Ball"].data.vertices, "f4", 3, lambda v: v.co * 2))  # not what it should be

    def test_normals_are_the_same_each_time(self):
        """Blender 3.x sums them in the order of its threads, which has 18 results of 30 for this ball."""
        self.new()
        o = built.ball("Ball", built.material("glass", "ShaderNodeBsdfGlass"), (0, 0, 0), 1.0, segments=512)
        seen = set()
        for _ in range(20):
            o.data.update()
            seen.add(meshes.vertex_normals(o.data, True).tobytes())
        self.assertEqual(len(seen), 1)
        made = np.frombuffer(seen.pop(), "f4").reshape(-1, 3)
        co = meshes.positions(o.data, True)
        np.testing.assert_allclose(made, co / np.linalg.norm(co, axis=1, keepdims=True), atol=1e-3 if NEW else 2e-4)
        own = meshes.by_foreach(o.data.vertex_normals, "vector", "f4", 3)
        np.testing.assert_allclose(made, own, atol=2e-3)
        np.testing.assert_allclose(made, meshes.vertex_normals(o.data, False), rtol=0, atol=0)

    def test_normals_of_any_faces(self):
        """Faces of three to five corners, one of no area, and a vertex of no face, against Blender's own."""
        self.new()
        n = 40
        v = [(x / n, y / n, 0.1 * math.sin(9 * x / n) * math.cos(7 * y / n)) for y in range(n + 1) for x in range(n + 1)] + [(0.5, 0.5, 2.0), (0.0, 0.0, -1.0)]
        f = []
        for y in range(n):
            for x in range(n):
                a, b, c, d = y * (n + 1) + x, y * (n + 1) + x + 1, (y + 1) * (n + 1) + x + 1, (y + 1) * (n + 1) + x
                f += [(a, b, c, d)] if (x + y) % 2 else [(a, b, c), (a, c, d)]
        top = n * (n + 1)
        f += [(top, top + 1, top + 2, top + 3, len(v) - 2), (top, top + 1, top)[:2] + (top + 2,)]
        o = built.mesh("Sheet", v, f, built.material("m", "ShaderNodeBsdfGlass"), True)
        self.assertGreater(len(f), meshes.RACES)
        np.testing.assert_allclose(meshes.vertex_normals(o.data, True), meshes.by_foreach(o.data.vertex_normals, "vector", "f4", 3), atol=1e-4)

    def test_parts(self):
        """Two materials, smooth and flat faces, sharp edges: parts whose triangles are together those of the mesh."""
        self.new()
        o = built.table()
        o.data.materials.append(built.material("blue", "ShaderNodeBsdfDiffuse", Color=(0, 0, 1, 1)))
        for i, p in enumerate(o.data.polygons):
            p.material_index, p.use_smooth = i % 2, i % 3 > 0
        o.data.update()
        made = self.export()
        parts = [x for x in made.doc["objects"] if x["name"].startswith("Ball")]
        self.assertEqual(sorted((x["material"], x["smooth"]) for x in parts), [("blue", False), ("blue", True), ("glass", False), ("glass", True)])
        o.data.calc_loop_triangles()
        self.assertEqual(made.triangles, len(o.data.loop_triangles) + 2)

    def test_sharp_edges(self):
        """Normals per corner: a cube smoothed with sharp edges has those of its faces."""
        self.new()
        built.table()
        v = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        f = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        o = built.mesh("Cube", v, f, None, True)
        if hasattr(o.data, "use_auto_smooth"):
            o.data.use_auto_smooth, o.data.auto_smooth_angle = True, math.radians(30)
        else:
            o.data.set_sharp_from_angle(angle=math.radians(30))
        made = self.export()
        cube, = [x for x in made.doc["objects"] if x["name"] == "Cube"]
        v, n, tri = read_ply(self.path("scene/" + cube["file"]))
        if not cube["smooth"]:  # 4.1 on: known to be flat all over
            self.assertTrue(NEW)
            return
        self.assertEqual((len(v), len(tri)), (24, 12))
        flat = np.cross(v[tri[:, 1]] - v[tri[:, 0]], v[tri[:, 2]] - v[tri[:, 0]])
        flat /= np.linalg.norm(flat, axis=1)[:, None]
        np.testing.assert_allclose(n[tri], np.repeat(flat[:, None], 3, 1), atol=1e-4)

    def test_visibility(self):
        scene = self.new()
        o = built.table()
        o.visible_camera = o.visible_shadow = False
        o.caustics.receives = False
        hidden = built.ball("Hidden", None, (1, 1, 1), 0.2)
        hidden.hide_render = True
        scene.objects["Key"].caustics.casts = False
        doc = self.export().doc
        self.assertEqual([x["name"] for x in doc["objects"]], ["Floor", "Ball"] if doc["objects"][0]["name"] == "Floor" else ["Ball", "Floor"])
        ball, = [x for x in doc["objects"] if x["name"] == "Ball"]
        self.assertEqual((ball["visible_to_camera"], ball["visible_to"], ball["receives_caustics"]), (False, ["diffuse", "glossy", "transmission"], False))
        self.assertIs(doc["lights"][0]["casts_caustics"], False)

    def test_left_out(self):
        self.new()
        built.table()
        built.link("Smoke", bpy.data.volumes.new("Smoke"))
        lines = self.export().notes.lines
        self.assertTrue(any(line.startswith('Object "Smoke": volumes are not built') for line in lines), lines)


class Lights(Case):
    def test_area_scale(self):
        """The scale of an area light counts in its size; its power is what it is."""
        scene = self.new()
        built.table()
        o = scene.objects["Key"]
        o.data.shape, o.data.size, o.data.size_y, o.data.spread = "ELLIPSE", 0.2, 0.4, math.radians(90)
        o.matrix_world = o.matrix_world @ Matrix.Diagonal((2, 3, 5, 1))
        light = self.export().doc["lights"][0]
        self.assertEqual(light["shape"], "disk")
        self.assertAlmostEqual(light["power_w"], 100.0 * (4 / math.pi if NEW else 1), 4)  # measured: from 4.2 on P / (pi area)
        np.testing.assert_allclose(light["size"] + [light["spread_deg"]], [0.4, 1.2, 90.0], rtol=1e-5)
        m = np.array(light["matrix"])[:3, :3]
        np.testing.assert_allclose(m @ m.T, np.eye(3), atol=1e-6)

    def test_nodes(self):
        scene = self.new()
        built.table()
        data = scene.objects["Key"].data
        data.use_nodes = True
        n = data.node_tree.nodes["Emission"]
        n.inputs["Strength"].default_value, n.inputs["Color"].default_value = 0.5, (1, 0.5, 0.25, 1)
        light = self.export().doc["lights"][0]
        self.assertAlmostEqual(light["power_w"], 50.0 * (4 / math.pi if NEW else 1), 4)
        np.testing.assert_allclose(light["color"], [1, 0.5, 0.25])

    def test_wide_sun(self):
        """3.4 renders 0.904 of the strength of a sun of 1.2 radians, 4.2 all of it."""
        self.new()
        built.table()
        built.lamp("Sun", "SUN", (0, 0, 5), (0, 0, 0), 3.0, angle=1.2)
        light, = [x for x in self.export().doc["lights"] if x["type"] == "sun"]
        self.assertAlmostEqual(light["strength"] / 3, 1.0 if NEW else 0.9043, 3)

    @unittest.skipUnless("normalize" in bpy.types.Light.bl_rna.properties, "4.5 on")
    def test_not_normalized(self):
        """Lamps of any size shine on what they reach as bench/blender/lamps.py has measured them."""
        self.new()
        for kind, area, values in (("AREA", 0.125, {"shape": "RECTANGLE", "size": 0.5, "size_y": 0.25}), ("AREA", math.pi / 16, {"shape": "DISK", "size": 0.5}),
                                   ("POINT", 4 * math.pi * 0.04, {"shadow_soft_size": 0.2}), ("POINT", 4, {"shadow_soft_size": 0.0}),
                                   ("SUN", math.pi * math.sin(0.1) ** 2, {"angle": 0.2}), ("SUN", 1, {"angle": 0.0})):
            built.empty()
            lamps = [built.lamp(str(n), kind, (0, 0, 3), (0, 0, 0), 10.0, normalize=n, **values) for n in (True, False)]
            built.camera()
            lights = {light["name"]: light for light in self.export().doc["lights"]}
            key = "strength" if kind == "SUN" else "power_w"
            self.assertAlmostEqual(lights["False"][key] / lights["True"][key] / area, 1.0, 5, (kind, values, lamps))

    def test_spot(self):
        self.new()
        built.table()
        built.lamp("Spot", "SPOT", (0, 0, 5), (0, 0, 0), 3.0, spot_size=1.0)
        light, = [x for x in self.export().doc["lights"] if x["type"] == "spot"]
        self.assertEqual(light.get("falloff"), "none" if NEW else None)

    def test_bodies(self):
        """Lamps with a radius are disks that face what they light, up to 3.x and with Soft Falloff."""
        self.new()
        built.camera()
        for name, values in (("Soft", {}), ("Hard", {"use_soft_falloff": False}), ("Point", {"shadow_soft_size": 0.0})):
            lamp = built.lamp(name, "POINT", (0, 0, 5), (0, 0, 0), 3.0, shadow_soft_size=0.5)
            for key, value in values.items():
                if hasattr(lamp.data, key):
                    setattr(lamp.data, key, value)
        bodies = {x["name"]: x.get("body") for x in self.export().doc["lights"]}
        always = "use_soft_falloff" not in bpy.types.PointLight.bl_rna.properties
        self.assertEqual(bodies, {"Soft": "disk", "Hard": "disk" if always else None, "Point": None})

    def test_world(self):
        scene = self.new()
        built.table()
        world = scene.world
        world.use_nodes = True
        back = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
        back.inputs[0].default_value, back.inputs[1].default_value = (0.1, 0.2, 0.3, 1), 2.0
        doc = self.export().doc
        self.assertEqual(doc["world"]["strength"], 2.0)
        np.testing.assert_allclose(doc["world"]["color"], [0.1, 0.2, 0.3], rtol=1e-6)
        sky = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
        world.node_tree.links.new(sky.outputs[0], back.inputs[0])
        made = self.export()
        self.assertNotIn("world", made.doc)
        self.assertTrue(any(line.startswith("World: its light is not constant") for line in made.notes.lines))


if __name__ == "__main__":
    import __main__
    run(__main__)
