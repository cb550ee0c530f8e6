# SPDX-License-Identifier: Apache-2.0
"""Scenes that artists build and scene files do not have, each as `name(scene)` on an empty scene."""
import math

import bpy
import numpy as np
from mathutils import Matrix, Vector


def empty():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    c = scene.cycles
    c.device, c.samples, c.use_adaptive_sampling, c.use_denoising = "CPU", 2, False, False
    c.caustics_reflective = c.caustics_refractive = True
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 96, 54, 100
    scene.render.threads_mode, scene.render.threads = "FIXED", 2
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    next(n for n in world.node_tree.nodes if n.type == "BACKGROUND").inputs["Color"].default_value = (0, 0, 0, 1)
    scene.world = world
    return scene


def link(name, data):
    o = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(o)
    return o


def aim(o, eye, to):
    o.matrix_world = Matrix.Translation(eye) @ (Vector(to) - Vector(eye)).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    return o


def material(name, kind, **values):
    """A material of one shader node; values are its inputs."""
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    tree = m.node_tree
    tree.nodes.clear()
    out, n = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new(kind)
    for key, value in values.items():
        n.inputs[key.replace("_", " ")].default_value = value
    tree.links.new(n.outputs[0], out.inputs["Surface"])
    return m


def mesh(name, vertices, faces, m=None, smooth=False):
    me = bpy.data.meshes.new(name)
    me.from_pydata(vertices, [], faces)
    me.polygons.foreach_set("use_smooth", [smooth] * len(me.polygons))
    if m:
        me.materials.append(m)
    me.update()
    return link(name, me)


def ball(name, m, at, radius, segments=24):
    v, f = [(0, 0, -1)], []
    rings = segments // 2
    for j in range(1, rings):
        t = math.pi * j / rings
        v += [(math.sin(t) * math.cos(2 * math.pi * i / segments), math.sin(t) * math.sin(2 * math.pi * i / segments), -math.cos(t))
              for i in range(segments)]
    v.append((0, 0, 1))
    for i in range(segments):
        k = (i + 1) % segments
        f.append((0, 1 + k, 1 + i))
        f += [(1 + j * segments + i, 1 + j * segments + k, 1 + (j + 1) * segments + k, 1 + (j + 1) * segments + i) for j in range(rings - 2)]
        f.append((1 + (rings - 2) * segments + i, 1 + (rings - 2) * segments + k, len(v) - 1))
    o = mesh(name, v, f, m, True)
    o.matrix_world = Matrix.Translation(at) @ Matrix.Scale(radius, 4)
    return o


def floor(m):
    return mesh("Floor", [(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [(0, 1, 2, 3)], m)


def lamp(name, kind, eye, to, energy, **values):
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    for key, value in values.items():
        setattr(data, key, value)
    return aim(link(name, data), eye, to)


def camera(eye=(0, -4, 2.5), to=(0, 0, 0.4), **values):
    data = bpy.data.cameras.new("Camera")
    for key, value in values.items():
        setattr(data, key, value)
    bpy.context.scene.camera = aim(link("Camera", data), eye, to)
    return bpy.context.scene.camera


def table(glass_at=(0, 0, 0.7)):
    """Floor, glass ball, area light, camera; what the scenes below start from."""
    floor(material("white", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.7, 0.6, 1)))
    glass = material("glass", "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.5, Color=(1, 0.95, 0.9, 1))
    lamp("Key", "AREA", (2, 1, 3), (0, 0, 0.5), 100.0, size=0.3)
    camera()
    bpy.context.view_layer.update()
    return ball("Ball", glass, glass_at, 0.5) if glass_at else glass


def instances(scene):
    """A collection of two objects, placed three times, once mirrored."""
    o = table((0, 0, 0))
    inner = bpy.data.collections.new("Pair")
    scene.collection.objects.unlink(o)
    inner.objects.link(o)
    o.scale = (0.25, 0.25, 0.25)
    for i, s in enumerate((1, -1, 0.6)):
        e = link(f"Place{i}", None)
        e.instance_type, e.instance_collection = "COLLECTION", inner
        e.location, e.scale = (i - 1, 0.3 * i, 0.5), (s, 1, 1)


def modifiers(scene):
    """Subdivision that differs between viewport and render, an array, a bevel that is off in renders."""
    o = table()
    o.modifiers.new("Sub", "SUBSURF")
    o.modifiers["Sub"].levels, o.modifiers["Sub"].render_levels = 0, 2
    array = o.modifiers.new("Array", "ARRAY")
    array.count, array.relative_offset_displace = 2, (1.2, 0, 0)
    off = o.modifiers.new("Off", "DECIMATE")
    off.ratio, off.show_render = 0.1, False


def negative(scene):
    """Mirrored and unevenly scaled."""
    o = table()
    o.matrix_world = Matrix.Translation((0.1, 0, 0.8)) @ Matrix.Rotation(0.4, 4, "Y") @ Matrix.Diagonal((-0.5, 0.3, 0.7, 1))


def border_crop(scene):
    table()
    r = scene.render
    r.use_border = r.use_crop_to_border = True
    r.border_min_x, r.border_max_x, r.border_min_y, r.border_max_y = 0.3, 0.8, 0.1, 0.75


def ortho(scene):
    table()
    data = scene.camera.data
    data.type, data.ortho_scale, data.shift_x, data.shift_y = "ORTHO", 3.5, 0.1, -0.05
    scene.render.pixel_aspect_x = 1.5


def two_groups(scene):
    """Three lights, two of them in one light group."""
    table()
    layer = scene.view_layers[0]
    for name in ("warm", "cold"):
        layer.lightgroups.add(name=name)
    lamp("Fill", "POINT", (-2, -1, 2), (0, 0, 0), 60.0, color=(0.4, 0.6, 1), shadow_soft_size=0.1).lightgroup = "cold"
    lamp("Rim.001", "SPOT", (0, 2, 3), (0, 0, 0.5), 200.0, spot_size=math.radians(50), shadow_soft_size=0.05).lightgroup = "warm"
    scene.objects["Key"].lightgroup = "warm"


def textured(scene):
    """A checkered floor."""
    table()
    image = bpy.data.images.new("Checks", 16, 16, float_buffer=True)
    pixels = [c for y in range(16) for x in range(16) for c in ((0.8, 0.2, 0.1, 1) if (x // 4 + y // 4) % 2 else (0.2, 0.4, 0.8, 1))]
    image.pixels.foreach_set(pixels)
    image.update()
    image.pack()
    o = scene.objects["Floor"]
    o.data.uv_layers.new().data.foreach_set("uv", [0, 0, 1, 0, 1, 1, 0, 1])
    tree = o.data.materials[0].node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image, node.interpolation = image, "Closest"
    tree.links.new(node.outputs[0], tree.nodes["Diffuse BSDF"].inputs["Color"])


def textured_seen(scene, repeat=8):
    """The checkered floor's caustic also through a glass ball in front of it (in the middle) and in a mirror (on the left).
    Finer checks: there their mean stands in."""
    textured(scene)
    scene.objects["Floor"].data.uv_layers[0].data.foreach_set("uv", [repeat * x for x in (0, 0, 1, 0, 1, 1, 0, 1)])
    scene.camera.data.angle = math.radians(70)
    ball("Front", scene.objects["Ball"].data.materials[0], (-0.25, -2.15, 1.25), 0.25)
    mirror = material("mirror", "ShaderNodeBsdfGlossy" if bpy.app.version < (4, 0, 0) else "ShaderNodeBsdfAnisotropic", Color=(0.9, 0.9, 0.9, 1), Roughness=0.0)
    mesh("Mirror", [(-1.5, -2.5, 0.01), (-1.5, 0.5, 0.01), (-1.5, 0.5, 1.5), (-1.5, -2.5, 1.5)], [(0, 1, 2, 3)], mirror)
    bpy.context.view_layer.update()


def halves(albedo):
    """Of textured_seen: {name: mask} of the pixels that see no receiver, from the Diffuse Color pass."""
    dark, left = albedo.max(-1) < 1e-3, np.arange(albedo.shape[1]) < 0.3 * albedo.shape[1]
    return {"mirror": dark & left, "glass": dark & ~left}


def node_group(scene):
    """Glass inside a node group, its index of refraction computed from a socket of the group."""
    o = table()
    group = bpy.data.node_groups.new("Glassy", "ShaderNodeTree")
    if hasattr(group, "interface"):
        group.interface.new_socket("Extra", in_out="INPUT", socket_type="NodeSocketFloat")
        group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    else:
        group.inputs.new("NodeSocketFloat", "Extra")
        group.outputs.new("NodeSocketShader", "Shader")
    inside, outside = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    add, glass = group.nodes.new("ShaderNodeMath"), group.nodes.new("ShaderNodeBsdfGlass")
    add.inputs[1].default_value = 1.25
    glass.inputs["Roughness"].default_value = 0.0
    group.links.new(inside.outputs[0], add.inputs[0])
    group.links.new(add.outputs[0], glass.inputs["IOR"])
    group.links.new(glass.outputs[0], outside.inputs[0])
    m = bpy.data.materials.new("grouped")
    m.use_nodes = True
    m.node_tree.nodes.clear()
    node, out = m.node_tree.nodes.new("ShaderNodeGroup"), m.node_tree.nodes.new("ShaderNodeOutputMaterial")
    node.node_tree = group
    node.inputs[0].default_value = 0.25
    m.node_tree.links.new(node.outputs[0], out.inputs["Surface"])
    o.data.materials[0] = m


SCENES = {f.__name__: f for f in (instances, modifiers, negative, border_crop, ortho, two_groups, textured, textured_seen, node_group)}
