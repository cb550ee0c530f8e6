# SPDX-License-Identifier: Apache-2.0
"""What users set: per scene, per object and light, and in the preferences."""
import os

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from .options import Options


class CausticsLine(bpy.types.PropertyGroup):
    text: StringProperty()


class CausticsScene(bpy.types.PropertyGroup):
    quality: EnumProperty(name="Quality", default="GOOD", items=(
        ("DRAFT", "Draft", "Noise of 20 %"), ("GOOD", "Good", "Noise of 5 %"), ("FINAL", "Final", "Noise of 2 %"),
        ("ERROR", "Error", "Noise as set below")))
    error_percent: FloatProperty(name="Error", default=5.0, min=0.01, max=100.0, subtype="PERCENTAGE",
                                 description="Noise (RMSE over RMS of the layers) at which to stop")
    time_s: FloatProperty(name="Time Limit", default=600.0, min=0.0, soft_max=36000.0, unit="TIME_ABSOLUTE",
                          description="Stop here whatever the noise; 0 for no limit")
    beauty: EnumProperty(name="Picture", default="RENDER", items=(
        ("RENDER", "Render It", "Render with caustics of Cycles off, then add ours"),
        ("LAST", "Last Render", "Add to the last render, made with caustics of Cycles off"),
        ("NONE", "None", "Make the layers only")))
    photons_million: FloatProperty(name="Million Photons", default=0.0, min=0.0, soft_max=1000.0,
                                   description="Per light, in place of quality and time; the result is then the same bytes every time. 0 for none")
    indirect: EnumProperty(name="Indirect", default="AUTO", items=(
        ("AUTO", "Automatic", "Where probes find that they matter"), ("ON", "On", "Always"), ("OFF", "Off", "Never")),
        description="Caustic light that bounces on, and lit surfaces seen through glass by other surfaces")
    seed: IntProperty(name="Seed", default=0, min=0, description="Another set of random numbers; the same for all frames, so that noise stands still")
    threads: IntProperty(name="Threads", default=0, min=0, max=1024, description="0: one per processor")
    memory_gb: FloatProperty(name="Memory", default=0.0, min=0.0, soft_max=64.0, description="Budget in GB; 0: the renderer's default of 2")
    error_layers: BoolProperty(name="Error Layers", description="Write the standard error of every pixel as layers too")
    keep_beauty: BoolProperty(name="Keep the Picture", description="Keep Cycles' own picture as a file beside the result")
    output: StringProperty(name="Output", subtype="FILE_PATH", default="//caustics/",
                           description="Path of the result, or a folder; its name is then that of the blend file")
    nodes: BoolProperty(name="Compositor Nodes", default=True, description="Add a node group with sliders for every light to the compositor")
    follow_lights: BoolProperty(name="Follow Lights", description="Drive each light's gain in the compositor by the strength of the light itself: "
                                "a change of it brightens its caustics without tracing them again")
    with_render: BoolProperty(name="With Every Render", description="Make caustics with each F12 and each frame of Render Animation")
    plan: CollectionProperty(type=CausticsLine)
    notes: CollectionProperty(type=CausticsLine)
    result: StringProperty()

    def path(self):
        """Of the result, without ending."""
        scene = self.id_data
        name = os.path.splitext(os.path.basename(bpy.data.filepath))[0] or "untitled"
        if len(bpy.data.scenes) > 1:
            name += "_" + scene.name
        given = self.output
        if given.startswith("//") and not bpy.data.filepath:
            given = os.path.join(bpy.app.tempdir, given[2:])
        given = os.path.abspath(bpy.path.abspath(given))
        folder = self.output.endswith(("/", "\\")) or os.path.isdir(given)
        return os.path.join(given, name) if folder else os.path.splitext(given)[0]

    def options(self, **more):
        values = {"output": self.path(), "quality": self.error_percent / 100 if self.quality == "ERROR" else self.quality, "time_s": self.time_s,
                  "photons": round(self.photons_million * 1e6), "beauty": self.beauty, "indirect": self.indirect, "seed": self.seed,
                  "threads": self.threads, "memory": f"{round(self.memory_gb * 1024)}M" if self.memory_gb else "",
                  "error_layers": self.error_layers, "keep_beauty": self.keep_beauty, "in_process": in_process()}
        return Options(**{**values, **more})

    def show(self, job):
        for lines, texts in ((self.plan, job.plan.splitlines()), (self.notes, job.notes)):
            lines.clear()
            for text in texts:
                lines.add().text = text.strip()
        self.result = job.result or job.caustics or ""


class CausticsObject(bpy.types.PropertyGroup):
    casts: BoolProperty(name="Casts Caustics", default=True, description="Off: makes none, still blocks light; a light has no layer")
    receives: BoolProperty(name="Receives Caustics", default=True)


class CausticsPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    programs: StringProperty(name="Programs", subtype="DIR_PATH", description="Folder of caustic-render and caustic-merge; empty: those of the add-on")
    in_process: BoolProperty(name="In Process", description="Load the renderer into Blender instead of running it beside: an error in it is then one of Blender's")

    def draw(self, context):
        self.layout.prop(self, "programs")
        self.layout.prop(self, "in_process")


def in_process():
    addon = bpy.context.preferences.addons.get(__package__)
    return bool(addon and addon.preferences and addon.preferences.in_process)


CLASSES = (CausticsLine, CausticsScene, CausticsObject, CausticsPreferences)


def register():
    for c in CLASSES:
        bpy.utils.register_class(c)
    bpy.types.Scene.caustics = PointerProperty(type=CausticsScene)
    bpy.types.Object.caustics = PointerProperty(type=CausticsObject)


def unregister():
    del bpy.types.Object.caustics
    del bpy.types.Scene.caustics
    for c in reversed(CLASSES):
        bpy.utils.unregister_class(c)
