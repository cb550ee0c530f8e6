# SPDX-License-Identifier: Apache-2.0
"""The buttons."""
import os
import time

import bpy
from bpy.props import StringProperty

from . import command, show
from .errors import Cancelled, CausticsError
from .job import Job

TICK_S = 0.05
REDRAW_S = 0.5  # drawing costs more than the rest


class CAUSTICS_OT_generate(bpy.types.Operator):
    bl_idname = "caustics.generate"
    bl_label = "Generate Caustics"
    bl_description = "Render the picture without caustics, trace the caustics of every light, and add them"
    job = None  # the one that runs, for the panels

    @classmethod
    def poll(cls, context):
        return cls.job is None

    def begin(self, context, interactive):
        settings = context.scene.caustics
        self.shown, self.drawn = None, 0.0
        return Job(context.scene, context.view_layer, settings.options(), interactive)

    def execute(self, context):
        try:
            job = self.begin(context, False).run()
        except CausticsError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.finish(context, job)
        return {"FINISHED"}

    def invoke(self, context, event):
        cls = CAUSTICS_OT_generate
        try:
            cls.job = self.begin(context, not bpy.app.background)
        except CausticsError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.steps = cls.job.steps()
        self.timer = context.window_manager.event_timer_add(TICK_S, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            CAUSTICS_OT_generate.job.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        job = CAUSTICS_OT_generate.job
        try:
            next(self.steps)
        except StopIteration:
            self.end(context)
            self.finish(context, job)
            return {"FINISHED"}
        except Cancelled as error:
            self.end(context)
            self.report({"WARNING"}, str(error))
            return {"CANCELLED"}
        except CausticsError as error:
            self.end(context)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        except Exception:
            self.end(context)
            raise
        shown = (job.text, round(20 * job.progress))
        if shown != self.shown and time.monotonic() - self.drawn > REDRAW_S:
            self.shown, self.drawn = shown, time.monotonic()
            redraw(context)
        return {"RUNNING_MODAL"}

    def cancel(self, context):
        """Blender ends the operator: with the window, or with the file."""
        self.steps.close()
        self.end(context)

    def end(self, context):
        CAUSTICS_OT_generate.job = None
        if self.timer:
            context.window_manager.event_timer_remove(self.timer)
            self.timer = None
        redraw(context)

    def finish(self, context, job):
        settings = bpy.data.scenes[job.scene].caustics
        settings.show(job)
        show.images(job, context)
        if settings.nodes and job.options.beauty != "NONE":
            try:
                for line in show.nodes(job, settings.follow_lights):
                    settings.notes.add().text = line
            except CausticsError as error:
                self.report({"WARNING"}, str(error))
        self.report({"INFO"}, f"Caustics: {job.result or job.caustics}")


class CAUSTICS_OT_cancel(bpy.types.Operator):
    bl_idname = "caustics.cancel"
    bl_label = "Cancel"
    bl_description = "Stop; all settings go back to what they were"

    @classmethod
    def poll(cls, context):
        return CAUSTICS_OT_generate.job is not None

    def execute(self, context):
        CAUSTICS_OT_generate.job.cancel()
        return {"FINISHED"}


class CAUSTICS_OT_export(bpy.types.Operator):
    bl_idname = "caustics.export"
    bl_label = "Export Caustics Scene"
    bl_description = "Write the scene as a scene file with its meshes, for caustic-render in a shell or on a farm"
    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def invoke(self, context, event):
        if not self.filepath:
            self.filepath = os.path.splitext(bpy.data.filepath or "untitled")[0] + "_caustics"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            made = command.export(bpy.path.abspath(self.filepath), context.scene, context.view_layer)
        except CausticsError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for line in made.notes.lines:
            self.report({"WARNING"}, line)
        self.report({"INFO"}, f"Scene: {made.path}")
        return {"FINISHED"}


def redraw(context):
    """The panels alone: the view itself may take seconds."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions:
                if (area.type, region.type) in (("PROPERTIES", "WINDOW"), ("VIEW_3D", "UI")):
                    region.tag_redraw()


CLASSES = (CAUSTICS_OT_generate, CAUSTICS_OT_cancel, CAUSTICS_OT_export)


def menu(self, context):
    self.layout.operator(CAUSTICS_OT_export.bl_idname, text="Caustics Scene (.json)")


def register():
    for c in CLASSES:
        bpy.utils.register_class(c)
    bpy.types.TOPBAR_MT_file_export.append(menu)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(menu)
    for c in reversed(CLASSES):
        bpy.utils.unregister_class(c)
