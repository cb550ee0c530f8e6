# SPDX-License-Identifier: Apache-2.0
"""The result in Blender: an image in the Image Editor, and compositor nodes with sliders for every light."""
import os

import bpy

from . import follow, pictures, programs
from .errors import CausticsError

IMAGE = "Caustics"


def images(job, context=None):
    """Loads the result (or the layers where there is no picture) as the image "Caustics", anew each time."""
    path = job.result or job.caustics
    image = bpy.data.images.get(IMAGE)
    if image:
        image.filepath = path
        image.reload()
    else:
        image = bpy.data.images.load(path)
        image.name = IMAGE
    if context and context.window:
        for area in context.window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
    return image


def nodes(job, follow_lights=False):
    """Adds the node group of `caustic-merge blender` behind the scene's Render Layers. Returns notes."""
    script = os.path.splitext(job.caustics)[0] + "_nodes.py"
    words = ["blender", job.caustics, "-o", script]
    if job.albedo:
        words += ["--albedo", job.view_layer + "." + pictures.ALBEDO]
    place = programs.scratch()
    try:
        child = programs.Child("caustic-merge", words, place)
        child.process.wait()
        child.check()
    finally:
        programs.remove(place)
    with open(script, encoding="utf-8") as f:
        code = compile(f.read(), script, "exec")
    scope = {"__name__": "caustics_nodes", "__file__": script}
    window = bpy.context.window
    scene, was = bpy.data.scenes[job.scene], bpy.context.scene
    try:
        if window and was != scene:
            window.scene = scene
        exec(code, scope)
        scope["build"]()
        return follow.drive(job, scope["scene_tree"](scene)) if follow_lights else []
    except RuntimeError as error:
        raise CausticsError(f"The compositor nodes could not be made: {error}.") from None
    finally:
        if window and was != scene:
            window.scene = was
