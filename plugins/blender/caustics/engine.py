# SPDX-License-Identifier: Apache-2.0
"""How the add-on gets at the scene that a render sees: modifiers at render level, what is hidden from renders left out.

Only a render engine is given that dependency graph. So either Cycles' own engine lets us look before it starts (Hook), or an
engine of ours renders nothing (SceneReader)."""
import bpy

from .errors import CausticsError


class Hook:
    """While open, `look(engine, depsgraph)` is called for each view layer that Cycles is about to render. What it raises
    is kept in `error`, and the render goes on."""

    def __init__(self, look):
        self.look, self.error, self.kept = look, None, None

    def open(self):
        try:
            from cycles import CyclesRender
        except ImportError:
            raise CausticsError("The add-on Cycles Render Engine is off; enable it in the preferences.") from None
        hook, update = self, CyclesRender.update

        def looking(engine, data, depsgraph):
            if not engine.is_preview:
                try:
                    hook.look(engine, depsgraph)
                except Exception as error:  # Blender would print it and render on: keep it for the user
                    hook.error = error.with_traceback(None)  # whose frames would keep the engine alive
            update(engine, data, depsgraph)

        CyclesRender.update = looking
        self.kept = CyclesRender, update
        return self

    def close(self):
        if self.kept:
            self.kept[0].update = self.kept[1]
            self.kept = None


class SceneReader(bpy.types.RenderEngine):
    """Renders nothing; hands the dependency graph to whoever asked."""
    bl_idname = "CAUSTICS_SCENE"
    bl_label = "Caustics (scene only)"
    bl_use_preview = False
    bl_use_postprocess = False
    look, error = None, None

    def update(self, data, depsgraph):
        if not SceneReader.look:
            return
        try:
            SceneReader.look(self, depsgraph)
        except Exception as error:
            SceneReader.error = error.with_traceback(None)

    def render(self, depsgraph):
        pass


def look_at(scene, view_layer, look):
    """Calls look(engine, depsgraph) for one view layer of a scene as it renders. The last render stays in its slot."""
    render, image = scene.render, bpy.data.images.get("Render Result")
    kept = {name: getattr(render, name) for name in ("engine", "use_compositing", "use_sequencer", "use_file_extension")}
    used = {layer.name: layer.use for layer in scene.view_layers}
    slot = image.render_slots.active_index if image else 0
    SceneReader.look, SceneReader.error = look, None
    try:
        if image and len(image.render_slots) > 1:
            image.render_slots.active_index = len(image.render_slots) - 1 if slot != len(image.render_slots) - 1 else 0
        render.use_compositing = render.use_sequencer = False
        for layer in scene.view_layers:
            layer.use = layer.name == view_layer
        render.engine = SceneReader.bl_idname
        bpy.ops.render.render(scene=scene.name)
    finally:
        SceneReader.look = None
        for name, value in kept.items():
            setattr(render, name, value)
        for layer in scene.view_layers:
            layer.use = used[layer.name]
        if image:
            image.render_slots.active_index = slot
    if SceneReader.error:
        raise SceneReader.error


def register():
    bpy.utils.register_class(SceneReader)


def unregister():
    bpy.utils.unregister_class(SceneReader)
