# SPDX-License-Identifier: Apache-2.0
"""Blender's camera and render settings in the scene format."""
import math

from .errors import CausticsError
from .lamps import rows, unscaled

SPACES = {"Linear": "lin_rec709_scene", "Linear Rec.709": "lin_rec709_scene", "Linear BT.709": "lin_rec709_scene",
          "ACEScg": "lin_ap1_scene", "Linear ACEScg": "lin_ap1_scene", "ACES2065-1": "lin_ap0_scene", "Linear ACES": "lin_ap0_scene",
          "Linear Rec.2020": "lin_rec2020_scene", "Linear BT.2020": "lin_rec2020_scene", "Linear P3-D65": "lin_p3d65_scene",
          "Linear DCI-P3 D65": "lin_p3d65_scene"}


def size(render):
    """Whole pixels of the picture, as Blender rounds them."""
    return render.resolution_x * render.resolution_percentage // 100, render.resolution_y * render.resolution_percentage // 100


def aspect(render):
    """Width of a pixel over its height."""
    return render.pixel_aspect_x / render.pixel_aspect_y


def region(render):
    """x0, y0, x1, y1 of the border, from the top left, ends exclusive; None for the whole picture."""
    if not render.use_border:
        return None
    w, h = size(render)
    x0, x1 = int(render.border_min_x * w), int(render.border_max_x * w)
    y0, y1 = int(render.border_min_y * h), int(render.border_max_y * h)
    if x0 >= x1 or y0 >= y1:
        raise CausticsError("The render border encloses no pixel; draw it anew or switch it off.")
    return x0, h - y1, x1, h - y0


def camera(obj, scene, notes):
    """The camera of the scene format, from an evaluated camera object."""
    if obj is None:
        raise CausticsError("The scene has no camera; add one and make it active.")
    data, render = obj.data, scene.render
    if obj.type != "CAMERA":
        raise CausticsError(f'The active camera "{obj.name}" is no camera but a {obj.type.lower()}; choose another.')
    if data.type not in ("PERSP", "ORTHO"):
        raise CausticsError(f'Camera "{obj.name}" is {data.type.lower()}, which is not built; make it perspective or orthographic.')
    m = unscaled(obj.matrix_world)
    if m is None or not all(math.isfinite(x) for row in m for x in row):
        raise CausticsError(f'Camera "{obj.name}" is scaled to nothing; its scale must not be 0.')
    w, h = size(render)
    if w < 1 or h < 1:
        raise CausticsError(f"The picture has {w} x {h} pixels; it must have one at least.")
    stretch = aspect(render)
    wide = w * stretch >= h if data.sensor_fit == "AUTO" else data.sensor_fit == "HORIZONTAL"
    to_width = 1.0 if wide else w * stretch / h  # what Blender measures along the fitted side, along the width
    made = {"matrix": rows(m), "resolution": [w, h], "pixel_aspect": stretch, "clip": [float(data.clip_start), float(data.clip_end)],
            "shift": [data.shift_x / to_width, data.shift_y / to_width]}
    if data.type == "ORTHO":
        made.update(type="orthographic", ortho_width=float(data.ortho_scale) * to_width)
    else:
        sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
        made.update(type="perspective", hfov_deg=2 * math.degrees(math.atan(sensor / (2 * data.lens) * to_width)))
    if data.dof.use_dof:
        notes.add(f'Camera "{obj.name}"', "lens blur is not built; caustics are sharp everywhere")
    if render.use_motion_blur:
        notes.add("Scene", "motion blur is not built; caustics stand still in each frame")
    if render.use_multiview:
        notes.add("Scene", "stereo is not built; the caustics are those of the middle camera")
    return {**made, **film(scene.cycles, notes)}


def film(cycles, notes):
    kind = cycles.pixel_filter_type.lower()
    width = 1.0 if kind == "box" else float(cycles.filter_width)
    return {"filter": {"type": kind, "width": width}, "exposure": float(cycles.film_exposure)}


def bounces(cycles):
    return {"total": cycles.max_bounces, "diffuse": cycles.diffuse_bounces, "glossy": cycles.glossy_bounces,
            "transmission": cycles.transmission_bounces}


def color_space(scene):
    """The working space: settable since 5.0, Rec.709 in Blender's own configuration before."""
    import bpy
    space = getattr(getattr(bpy.data, "colorspace", None), "working_space", None)
    if space is None:
        return "lin_rec709_scene"
    if space not in SPACES:
        raise CausticsError(f'The working color space is "{space}"; known are {", ".join(sorted(SPACES))}.')
    return SPACES[space]
