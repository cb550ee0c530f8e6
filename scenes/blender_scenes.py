# SPDX-License-Identifier: Apache-2.0
"""Build a scene file of this project in Blender, and render it with Cycles, caustics off or on.

  blender -b --factory-startup --python scenes/blender_scenes.py -- --scene scenes/a_ball.json --mode off \
      --spp 64 --seed 0 --res 480x270 --out a_off.exr [--multilayer] [--half] [--groups] [--threads 1]

Several renders in one process: repeat the options behind `--job`. Each prints one line `JOB {json}` with its user CPU
seconds. `--save FILE.blend` keeps the Blender scene, `--spp 0` renders nothing.

What has no exact counterpart in Cycles 3.4 and how it is built:
  plastic   with Schlick's term: Glossy over Diffuse, weighted so that the directional albedo towards the eye is that of
            the scene format (GGX coat, Schlick, the Lambert part scaled by one minus the coat's albedo).
            "fresnel": "dielectric": the Principled BSDF that artists use, in 3.4 with "base": "burley".
  metal     with edge_color unlike color: Glossy weighted in the same way (exact at roughness 0).
  exact sphere, cylinder, heightfield: fine meshes with smooth normals (shapes.py).
"""
import argparse
import json
import math
import os
import resource
import sys
import time

import bpy
import numpy as np
from mathutils import Euler, Matrix, Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import shapes  # noqa: E402


# ---- transforms ------------------------------------------------------------------------------------------------------

def look_matrix(look):
    eye, to = Vector(look["from"]), Vector(look["to"])
    f = (to - eye).normalized()
    up = Vector((0, 1, 0)) if abs(f.z) > 0.999999 else Vector((0, 0, 1))
    r = f.cross(up).normalized()
    u = r.cross(f)
    return Matrix(((r.x, u.x, -f.x, eye.x), (r.y, u.y, -f.y, eye.y), (r.z, u.z, -f.z, eye.z), (0, 0, 0, 1)))


def matrix_of(item):
    if "matrix" in item:
        return Matrix(item["matrix"])
    if "look" in item:
        return look_matrix(item["look"])
    s = item.get("scale", 1)
    s = (s, s, s) if isinstance(s, (int, float)) else s
    turn = Euler([math.radians(a) for a in item.get("rotation_deg", (0, 0, 0))], "XYZ").to_matrix().to_4x4()
    return Matrix.Translation(item.get("position", (0, 0, 0))) @ turn @ Matrix.Diagonal((*s, 1))


# ---- materials -------------------------------------------------------------------------------------------------------

def ggx_albedo(mu, roughness, fresnel, n=64):
    """Directional albedo of a reflecting GGX lobe (Walter 2007, separable Smith), by sampling visible normals."""
    a = roughness * roughness
    if a < 1e-6:
        return float(fresnel(np.array([mu]))[0])
    u1, u2 = (np.arange(n) + 0.5) / n, (np.arange(n) + 0.5) / n
    u1, u2 = (x.ravel() for x in np.meshgrid(u1, u2))
    v = np.array([math.sqrt(max(0, 1 - mu * mu)), 0, mu])
    vh = v * (a, a, 1)
    vh /= np.linalg.norm(vh)
    t1 = np.array([0.0, 1, 0]) if vh[2] > 0.9999999 else np.cross((0, 0, 1), vh) / math.hypot(vh[0], vh[1])
    t2 = np.cross(vh, t1)
    r, phi = np.sqrt(u1), 2 * np.pi * u2
    p1, p2, s = r * np.cos(phi), r * np.sin(phi), 0.5 * (1 + vh[2])
    p2 = (1 - s) * np.sqrt(np.maximum(0, 1 - p1 * p1)) + s * p2
    h = p1[:, None] * t1 + p2[:, None] * t2 + np.sqrt(np.maximum(0, 1 - p1 * p1 - p2 * p2))[:, None] * vh
    h = h * (a, a, 1)
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    c = h @ v
    lz = 2 * c * h[:, 2] - v[2]
    with np.errstate(divide="ignore", invalid="ignore"):
        tan2 = np.where(lz > 0, (1 - lz * lz) / (lz * lz), 0)
    g1 = np.where(lz > 0, 2 / (1 + np.sqrt(1 + a * a * tan2)), 0)
    return float(np.mean(g1 * fresnel(np.clip(c, 0, 1))))


def schlick(f0, f90=1.0):
    return lambda c: f0 + (f90 - f0) * (1 - c) ** 5


STOPS = 32  # what a colour ramp holds


def facing_ramp(tree, colors):
    """A colour that depends on the cosine between the shading normal and the eye: colors[i] at i / 31."""
    geo = tree.nodes.new("ShaderNodeNewGeometry")
    dot = tree.nodes.new("ShaderNodeVectorMath")
    dot.operation = "DOT_PRODUCT"
    tree.links.new(geo.outputs["Normal"], dot.inputs[0])
    tree.links.new(geo.outputs["Incoming"], dot.inputs[1])
    ab = tree.nodes.new("ShaderNodeMath")
    ab.operation = "ABSOLUTE"
    tree.links.new(dot.outputs["Value"], ab.inputs[0])
    ramp = tree.nodes.new("ShaderNodeValToRGB")
    el = ramp.color_ramp.elements
    el[0].position, el[1].position = 0.0, 1.0
    for i in range(1, STOPS - 1):
        el.new(i / (STOPS - 1))
    for i in range(STOPS):
        el[i].color = (*colors[i], 1)
    tree.links.new(ab.outputs[0], ramp.inputs[0])
    return ramp.outputs["Color"]


def set_input(node, names, value):
    for n in names:
        if n in node.inputs:
            node.inputs[n].default_value = value
            return


def glossy(tree, roughness):
    n = tree.nodes.new("ShaderNodeBsdfGlossy")
    set_distribution(n, roughness)
    n.inputs["Roughness"].default_value = roughness
    return n


def set_distribution(node, roughness):
    kinds = [e.identifier for e in node.bl_rna.properties["distribution"].enum_items]
    node.distribution = "SHARP" if roughness == 0 and "SHARP" in kinds else "GGX"


def plastic_principled(tree, m):
    n = tree.nodes.new("ShaderNodeBsdfPrincipled")
    if bpy.app.version < (4, 0, 0):  # from there on its default is Multiscatter GGX, as artists have it
        n.distribution = "GGX"
    n.inputs["Base Color"].default_value = (*m["color"], 1)
    n.inputs["Roughness"].default_value = m.get("roughness", 0.5)
    set_input(n, ("Specular", "Specular IOR Level"), m.get("specular", 0.5))
    for names in (("Metallic",), ("Sheen", "Sheen Weight"), ("Clearcoat", "Coat Weight"), ("Subsurface", "Subsurface Weight"),
                  ("Transmission", "Transmission Weight"), ("Anisotropic",)):
        set_input(n, names, 0.0)
    return n.outputs[0]


def plastic_match(tree, m):
    rough, f = m.get("roughness", 0.5), schlick(0.08 * m.get("specular", 0.5))
    mus = [max(i / (STOPS - 1), 1e-3) for i in range(STOPS)]
    coat = np.array([ggx_albedo(mu, rough, f) for mu in mus])
    full = np.array([ggx_albedo(mu, rough, lambda c: np.ones_like(c)) for mu in mus])
    g, d, add = glossy(tree, rough), tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(facing_ramp(tree, [(w, w, w) for w in coat / full]), g.inputs["Color"])
    tree.links.new(facing_ramp(tree, [tuple((1 - e) * c for c in m["color"]) for e in coat]), d.inputs["Color"])
    tree.links.new(d.outputs[0], add.inputs[0])
    tree.links.new(g.outputs[0], add.inputs[1])
    return add.outputs[0]


def metal(tree, m):
    color, edge, rough = m["color"], m.get("edge_color", (1, 1, 1)), m.get("roughness", 0.0)
    n = glossy(tree, rough)
    if list(color) == list(edge):
        n.inputs["Color"].default_value = (*color, 1)
        return n.outputs[0]
    mus = [max(i / (STOPS - 1), 1e-3) for i in range(STOPS)]
    full = [ggx_albedo(mu, rough, lambda c: np.ones_like(c)) for mu in mus]
    w = [tuple(ggx_albedo(mu, rough, schlick(c, e)) / a for c, e in zip(color, edge)) for mu, a in zip(mus, full)]
    tree.links.new(facing_ramp(tree, w), n.inputs["Color"])
    return n.outputs[0]


def material(name, m):
    mat = bpy.data.materials.new(name)
    mat.use_nodes = True
    tree = mat.node_tree
    tree.nodes.clear()
    out = tree.nodes.new("ShaderNodeOutputMaterial")
    kind = m["type"]
    for key in ("normal", "bump", "abbe", "priority"):
        if key in m:
            raise SystemExit("material '%s': '%s' is not built for Cycles here" % (name, key))
    if any(isinstance(v, dict) and "image" in v for v in m.values()):
        raise SystemExit("material '%s': textures are not built for Cycles here" % name)
    if kind == "diffuse":
        n = tree.nodes.new("ShaderNodeBsdfDiffuse")
        n.inputs["Color"].default_value = (*m["color"], 1)
        shader = n.outputs[0]
    elif kind == "plastic":
        shader = (plastic_principled if m.get("fresnel") == "dielectric" else plastic_match)(tree, m)
    elif kind == "metal":
        shader = metal(tree, m)
    elif kind == "glass":
        n = tree.nodes.new("ShaderNodeBsdfGlass")
        set_distribution(n, m.get("roughness", 0.0))
        n.inputs["Roughness"].default_value = m.get("roughness", 0.0)
        n.inputs["Color"].default_value = (*m.get("color", (1, 1, 1)), 1)
        n.inputs["IOR"].default_value = m.get("ior", 1.5)
        shader = n.outputs[0]
        if "absorption" in m:  # color^(path / distance), as density times (1 - colour) in Blender.
            sigma = [-math.log(max(c, 1e-6)) / m["absorption"]["distance_m"] for c in m["absorption"]["color"]]
            v = tree.nodes.new("ShaderNodeVolumeAbsorption")
            v.inputs["Density"].default_value = max(sigma)
            v.inputs["Color"].default_value = (*[1 - s / max(max(sigma), 1e-30) for s in sigma], 1)
            tree.links.new(v.outputs[0], out.inputs["Volume"])
    elif kind == "transparent":
        n = tree.nodes.new("ShaderNodeBsdfTransparent")
        n.inputs["Color"].default_value = (*m.get("color", (1, 1, 1)), 1)
        shader = n.outputs[0]
    elif kind == "emission":
        n = tree.nodes.new("ShaderNodeEmission")
        n.inputs["Color"].default_value = (*m.get("color", (1, 1, 1)), 1)
        n.inputs["Strength"].default_value = m.get("strength", 1.0)
        shader = n.outputs[0]
    else:
        raise SystemExit("material '%s': type '%s' is not known" % (name, kind))
    tree.links.new(shader, out.inputs["Surface"])
    return mat


# ---- objects, lights, camera, world ----------------------------------------------------------------------------------

def make_mesh(name, vertices, faces, smooth):
    me = bpy.data.meshes.new(name)
    counts = np.concatenate([np.full(len(f), f.shape[1]) for f in faces]).astype(np.int32)
    corners = np.concatenate([f.ravel() for f in faces]).astype(np.int32)
    me.vertices.add(len(vertices))
    me.vertices.foreach_set("co", np.asarray(vertices, np.float32).ravel())
    me.loops.add(len(corners))
    me.loops.foreach_set("vertex_index", corners)
    me.polygons.add(len(counts))
    me.polygons.foreach_set("loop_start", np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int32))
    me.polygons.foreach_set("loop_total", counts)
    me.polygons.foreach_set("use_smooth", np.full(len(counts), smooth))
    me.update(calc_edges=True)
    if me.validate():
        print("WARNING mesh '%s' was repaired by Blender" % name, flush=True)
    return me


def add_object(spec, materials, folder):
    if "file" in spec:
        if not spec["file"].endswith(".ply"):
            raise SystemExit("object '%s': only .ply files are built for Cycles here" % spec["name"])
        vertices, faces = shapes.read_ply(os.path.join(folder, spec["file"]))
    else:
        vertices, faces = shapes.from_json(spec["shape"])
    flat = "shape" in spec and spec["shape"]["type"] in ("plane", "box")
    me = make_mesh(spec["name"], vertices, faces, spec.get("smooth", True) and not flat)
    if "shape" in spec and "normals" in spec["shape"]:
        me.use_auto_smooth = True
        me.normals_split_custom_set_from_vertices(spec["shape"]["normals"])
    me.materials.append(materials[spec["material"]])
    o = bpy.data.objects.new(spec["name"], me)
    bpy.context.scene.collection.objects.link(o)
    o.matrix_world = matrix_of(spec)
    to = spec.get("visible_to", ("diffuse", "glossy", "transmission", "shadow"))
    o.visible_camera = spec.get("visible_to_camera", True)
    o.visible_diffuse, o.visible_glossy = "diffuse" in to, "glossy" in to
    o.visible_transmission, o.visible_shadow = "transmission" in to, "shadow" in to
    # Blender's crutches against the terminator of coarse smooth meshes would move shadows.
    o.cycles.shadow_terminator_offset = 0.0
    o.cycles.shadow_terminator_geometry_offset = 0.0
    return o


def add_light(spec):
    kind = spec["type"]
    l = bpy.data.lights.new(spec["name"], {"sun": "SUN", "point": "POINT", "spot": "SPOT", "area": "AREA"}[kind])
    l.color = spec.get("color", (1, 1, 1))
    l.energy = spec["strength"] if kind == "sun" else spec["power_w"]
    if kind == "area" and bpy.app.version >= (4, 0, 0):  # P / (pi area) there, P / (4 area) here
        l.energy *= math.pi / 4
    if kind == "sun":
        l.angle = math.radians(spec.get("angle_deg", 0.0))
    elif kind == "area":
        l.shape = {"rectangle": "RECTANGLE", "disk": "ELLIPSE"}[spec.get("shape", "rectangle")]
        l.size, l.size_y = spec["size"]
        l.spread = math.radians(spec.get("spread_deg", 180))
    else:
        l.shadow_soft_size = spec.get("radius_m", 0.0)
        if hasattr(l, "use_soft_falloff"):  # before 4.0 all are disks
            l.use_soft_falloff = spec.get("body") == "disk"
        if kind == "spot":
            l.spot_size, l.spot_blend = math.radians(spec["cone_deg"]), spec.get("blend", 0.15)
    o = bpy.data.objects.new(spec["name"], l)
    bpy.context.scene.collection.objects.link(o)
    o.matrix_world = matrix_of(spec)
    return o


def add_camera(spec):
    c = bpy.data.cameras.new("Camera")
    c.sensor_fit, c.sensor_width = "HORIZONTAL", 36
    if spec["type"] == "orthographic":
        c.type, c.ortho_scale = "ORTHO", spec["ortho_width"]
    else:
        c.type, c.lens_unit = "PERSP", "FOV"
        c.angle = math.radians(spec["hfov_deg"])
    c.shift_x, c.shift_y = spec.get("shift", (0, 0))
    c.clip_start, c.clip_end = spec.get("clip", (0.01, 1e6))
    o = bpy.data.objects.new("Camera", c)
    bpy.context.scene.collection.objects.link(o)
    o.matrix_world = matrix_of(spec)
    bpy.context.scene.camera = o


def add_world(spec, folder):
    w = bpy.data.worlds.new("World")
    bpy.context.scene.world = w
    w.use_nodes = True
    bg = w.node_tree.nodes["Background"]
    bg.inputs[0].default_value = (*spec.get("color", (0, 0, 0)), 1)
    bg.inputs[1].default_value = spec.get("strength", 1.0)
    if "image" in spec:
        env = w.node_tree.nodes.new("ShaderNodeTexEnvironment")
        env.image = bpy.data.images.load(os.path.join(folder, spec["image"]))
        coord = w.node_tree.nodes.new("ShaderNodeTexCoord")
        turn = w.node_tree.nodes.new("ShaderNodeMapping")
        turn.inputs["Rotation"].default_value[2] = math.radians(spec.get("rotation_deg", 0))
        w.node_tree.links.new(coord.outputs["Generated"], turn.inputs["Vector"])
        w.node_tree.links.new(turn.outputs[0], env.inputs["Vector"])
        w.node_tree.links.new(env.outputs[0], bg.inputs[0])


def light_groups(scene, doc, objects):
    """Every light in the group that its layer would bear: `group`, else its own name."""
    vl = scene.view_layers[0]
    have = set()

    def put(o, name):
        if name not in have:
            vl.lightgroups.add(name=name)
            have.add(name)
        o.lightgroup = name

    for spec in doc.get("lights", []):
        put(objects[spec["name"]], spec.get("group", spec["name"]))
    for spec in doc.get("objects", []):
        m = doc["materials"][spec["material"]]
        if m["type"] == "emission":
            put(objects[spec["name"]], m.get("group", spec["name"]))
    w = doc.get("world", {})
    if "image" in w or (max(w.get("color", (0, 0, 0))) > 0 and w.get("strength", 1) > 0):
        put(scene.world, w.get("group", "world"))


def build(path, options):
    """The scene file at `path` as the current Blender scene. Returns (scene, scene file's contents)."""
    with open(path, encoding="utf-8") as f:
        doc = json.load(f)
    folder = os.path.dirname(os.path.abspath(path))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    materials = {k: material(k, m) for k, m in doc.get("materials", {}).items()}
    objects = {}
    for spec in doc.get("objects", []):
        objects[spec["name"]] = add_object(spec, materials, folder)
    for spec in doc.get("lights", []):
        objects[spec["name"]] = add_light(spec)
    add_camera(doc["camera"])
    add_world(doc.get("world", {}), folder)
    if options.groups:
        light_groups(scene, doc, objects)
    return scene, doc


# ---- render settings -------------------------------------------------------------------------------------------------

def settings(scene, doc, options):
    scene.render.engine = "CYCLES"
    c, r, cam = scene.cycles, scene.render, doc["camera"]
    c.device = "CPU"
    c.samples, c.seed = max(options.spp, 1), options.seed
    c.use_adaptive_sampling = c.use_denoising = False
    c.sample_clamp_direct = c.sample_clamp_indirect = 0
    c.blur_glossy = 0.0
    c.light_sampling_threshold = 0.0
    b = doc.get("bounces", {"total": 128, "diffuse": 128, "glossy": 128, "transmission": 128})
    c.max_bounces, c.diffuse_bounces = b["total"], b["diffuse"]
    c.glossy_bounces, c.transmission_bounces = b["glossy"], b["transmission"]
    c.transparent_max_bounces, c.volume_bounces = 128, 0
    c.caustics_reflective = c.caustics_refractive = options.mode == "on"
    c.film_exposure = cam.get("exposure", 1.0)
    flt = cam.get("filter", {"type": "blackman_harris", "width": 1.5})
    c.pixel_filter_type = flt["type"].upper()
    c.filter_width = flt.get("width", 1.5)
    if flt["type"] == "box" and c.filter_width != 1.0:
        print("WARNING Cycles' box filter is always one pixel wide", flush=True)
    res = options.res or "%dx%d" % tuple(cam.get("resolution", (480, 270)))
    r.resolution_x, r.resolution_y = (int(t) for t in res.split("x"))
    r.resolution_percentage = 100
    pa = cam.get("pixel_aspect", 1.0)
    r.pixel_aspect_x, r.pixel_aspect_y = (pa, 1.0) if pa >= 1 else (1.0, 1.0 / pa)
    r.film_transparent = False
    r.use_persistent_data = False
    if options.threads:
        r.threads_mode, r.threads = "FIXED", options.threads
    im = r.image_settings
    im.file_format = "OPEN_EXR_MULTILAYER" if options.multilayer else "OPEN_EXR"
    im.color_mode, im.color_depth, im.exr_codec = "RGB", "16" if options.half else "32", "ZIP"
    if options.multilayer:
        vl = scene.view_layers[0]
        vl.use_pass_diffuse_color = vl.use_pass_glossy_color = vl.use_pass_transmission_color = True
        vl.use_pass_z = False


def parser():
    p = argparse.ArgumentParser(prog="blender_scenes.py")
    p.add_argument("--scene", required=True)
    p.add_argument("--mode", choices=("off", "on"), default="off")
    p.add_argument("--spp", type=int, default=64)
    p.add_argument("--seed", type=int, default=0)
    p.add_argument("--res", help="WxH, default: the scene file's")
    p.add_argument("--out", default="out.exr")
    p.add_argument("--groups", action="store_true", help="a light group per light or group")
    p.add_argument("--half", action="store_true")
    p.add_argument("--multilayer", action="store_true", help="MultiLayer EXR with colour passes")
    p.add_argument("--threads", type=int, default=0)
    p.add_argument("--save", help="write the Blender scene to this .blend")
    return p


def main():
    argv = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    jobs = [[]]
    for t in argv:
        if t == "--job":
            jobs.append([])
        else:
            jobs[-1].append(t)
    for job in jobs:
        options = parser().parse_args(job)
        scene, doc = build(options.scene, options)
        settings(scene, doc, options)
        bpy.context.view_layer.update()
        if options.save:
            bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(options.save))
        if options.spp == 0:
            continue
        scene.render.filepath = os.path.abspath(options.out)
        scene.render.use_file_extension = False
        u0, t0 = resource.getrusage(resource.RUSAGE_SELF).ru_utime, time.time()
        bpy.ops.render.render(write_still=True)
        print("JOB " + json.dumps({"scene": os.path.basename(options.scene), "mode": options.mode, "spp": options.spp,
                                   "seed": options.seed, "out": os.path.basename(options.out),
                                   "user": round(resource.getrusage(resource.RUSAGE_SELF).ru_utime - u0, 2),
                                   "wall": round(time.time() - t0, 2)}), flush=True)


if __name__ == "__main__":
    try:
        main()
    except BaseException as e:  # Blender would go on and exit with 0.
        if not isinstance(e, SystemExit) or e.code not in (None, 0):
            import traceback
            traceback.print_exc()
            sys.exit(1)
