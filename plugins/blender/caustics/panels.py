# SPDX-License-Identifier: Apache-2.0
"""The panels: Render properties, sidebar of the 3D view, and the object's own."""
import textwrap

import bpy

from . import switches
from .operators import CAUSTICS_OT_cancel, CAUSTICS_OT_export, CAUSTICS_OT_generate

ENGINES = {"CYCLES"}


class Panel:
    bl_label = "Caustics"

    @classmethod
    def poll(cls, context):
        return context.scene.render.engine in ENGINES

    def draw(self, context):
        layout, settings = self.layout, context.scene.caustics
        layout.use_property_split = True
        layout.use_property_decorate = False
        job = CAUSTICS_OT_generate.job
        if job:
            column = layout.column()
            if hasattr(layout, "progress"):  # 4.0 on
                column.progress(factor=job.progress, text=f"{100 * job.progress:.0f} %")
            else:
                column.label(text="#" * round(20 * job.progress) + "." * (20 - round(20 * job.progress)))
            text(column.column(), [job.text], "NONE", characters(context))
            column.operator(CAUSTICS_OT_cancel.bl_idname, icon="X")
            return
        layout.operator(CAUSTICS_OT_generate.bl_idname, icon="LIGHT_SUN")
        layout.prop(settings, "quality")
        if settings.quality == "ERROR":
            layout.prop(settings, "error_percent")
        layout.prop(settings, "time_s")
        for lines, icon in ((settings.plan, "INFO"), (settings.notes, "ERROR")):
            if len(lines):
                text(layout.box(), [line.text for line in lines], icon, characters(context))


def characters(context):
    """How many of a line fit into the panel, with its margins and an icon."""
    return max(20, int((context.region.width - 20) / 7.7 / context.preferences.system.ui_scale)) if context.region else 60


def text(layout, lines, icon, width):
    """Sentences, wrapped to the panel."""
    layout.scale_y = 0.7
    for line in lines:
        for i, piece in enumerate(textwrap.wrap(line, width)):
            layout.label(text=piece, icon=icon if i == 0 or icon == "NONE" else "BLANK1")


class Advanced:
    bl_label = "Advanced"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, settings = self.layout, context.scene.caustics
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("beauty", "output", "photons_million", "indirect", "seed", "threads", "memory_gb", "nodes", "follow_lights", "error_layers",
                     "keep_beauty", "with_render"):
            layout.prop(settings, name)
        switched = switches.describe(context.scene)
        if switched:
            text(layout.box(), switched, "INFO", characters(context))
        layout.operator(CAUSTICS_OT_export.bl_idname, icon="EXPORT")


class CAUSTICS_PT_render(Panel, bpy.types.Panel):
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"


class CAUSTICS_PT_render_advanced(Advanced, bpy.types.Panel):
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"
    bl_parent_id = "CAUSTICS_PT_render"


class CAUSTICS_PT_view(Panel, bpy.types.Panel):
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Caustics"


class CAUSTICS_PT_view_advanced(Advanced, bpy.types.Panel):
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "Caustics"
    bl_parent_id = "CAUSTICS_PT_view"


class CAUSTICS_PT_object(bpy.types.Panel):
    bl_label = "Caustics"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.scene.render.engine in ENGINES and context.object and context.object.type not in ("CAMERA", "ARMATURE", "SPEAKER")

    def draw(self, context):
        self.layout.prop(context.object.caustics, "casts")
        if context.object.type != "LIGHT":
            self.layout.prop(context.object.caustics, "receives")


CLASSES = (CAUSTICS_PT_render, CAUSTICS_PT_render_advanced, CAUSTICS_PT_view, CAUSTICS_PT_view_advanced, CAUSTICS_PT_object)


def register():
    for c in CLASSES:
        bpy.utils.register_class(c)


def unregister():
    for c in reversed(CLASSES):
        bpy.utils.unregister_class(c)
