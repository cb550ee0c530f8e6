# SPDX-License-Identifier: Apache-2.0
"""Small beauties as Blender 5 writes them: one part per pass. Needs the package bpy (made with 5.2.0, python3.13).

usage: blender5.py FOLDER     writes blender5_*.exr"""
import math
import os
import sys

import bpy

folder = sys.argv[-1]


def material(name, **inputs):
    m = bpy.data.materials.new(name)
    bsdf = next(n for n in m.node_tree.nodes if n.type == "BSDF_PRINCIPLED")
    for key, value in inputs.items():
        bsdf.inputs[key.replace("_", " ")].default_value = value
    return m


def lamp(name, kind, energy, place, group):
    light = bpy.data.lights.new(name, kind)
    light.energy = energy
    o = bpy.data.objects.new(name, light)
    o.location = place
    o.rotation_euler = (0, math.radians(35), 0)
    o.lightgroup = group
    bpy.context.scene.collection.objects.link(o)


def build():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_plane_add(size=6)
    bpy.context.object.name = "floor"
    bpy.context.object.data.materials.append(material("Floor", Base_Color=(.7, .6, .5, 1), Roughness=1.))
    bpy.ops.mesh.primitive_uv_sphere_add(radius=.6, location=(0, 0, .7), segments=24, ring_count=12)
    bpy.context.object.name = "glass.ball"
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(material("Glass", Transmission_Weight=1., Roughness=0., IOR=1.5))
    layer = scene.view_layers[0]
    for name in ("Key.001", "rim light", "2nd"):  # the first becomes Key_001
        layer.lightgroups.add(name=name)
    lamp("Key.001", "POINT", 300, (1.5, -1.5, 3), "Key_001")
    lamp("rim light", "AREA", 80, (-2, 1, 2), "rim light")
    lamp("2nd", "SUN", 1, (0, 0, 4), "2nd")
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -5, 2.2), (math.radians(70), 0, 0)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.seed = 16, False, 1
    scene.cycles.caustics_reflective = scene.cycles.caustics_refractive = False
    return scene, layer


def render(scene, name, width, height, depth="16", codec="ZIP", interleave=False):
    r = scene.render
    r.resolution_x, r.resolution_y, r.resolution_percentage, r.filepath = width, height, 100, os.path.join(folder, name)
    r.use_stamp_render_time = False
    s = r.image_settings
    s.media_type = "MULTI_LAYER_IMAGE"
    s.color_depth, s.exr_codec, s.use_exr_interleave = depth, codec, interleave
    bpy.ops.render.render(write_still=True)


scene, layer = build()
layer.use_pass_z = layer.use_pass_diffuse_direct = layer.use_pass_diffuse_color = True
layer.use_pass_object_index = layer.use_pass_cryptomatte_object = True
render(scene, "blender5_half.exr", 48, 27)
render(scene, "blender5_dwaa.exr", 48, 27, codec="DWAA")

scene.render.use_border, scene.render.use_crop_to_border = True, True
scene.render.border_min_x, scene.render.border_max_x = .25, .75
scene.render.border_min_y, scene.render.border_max_y = .2, .9
layer.use_pass_cryptomatte_object = False
render(scene, "blender5_crop.exr", 64, 36)
scene.render.use_border = False

layer.use_pass_object_index = False
second = scene.view_layers.new("Second layer")
second.use_pass_z = False
render(scene, "blender5_layers_float.exr", 32, 18, depth="32")
scene.view_layers.remove(second)

scene.render.use_multiview = True
scene.render.image_settings.views_format = "MULTIVIEW"
render(scene, "blender5_stereo.exr", 32, 18)
render(scene, "blender5_interleaved.exr", 32, 18, interleave=True)
