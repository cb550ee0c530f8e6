# SPDX-License-Identifier: Apache-2.0
"""Blender's lights and world in the scene format. Both count light alike (watts, W/m2, full sides), so numbers go over as
they are; what Blender says in nodes and in a light's scale is multiplied in. The format counts as 3.4 does; what later versions
count otherwise was measured in 4.2.23, 4.5.15, 5.0.1 and 5.2.3."""
import math

import bpy

from . import closures
from .fold import fold, socket


NEW = bpy.app.version >= (4, 0, 0)


def group_of(light_object, name):
    return {"group": light_object.lightgroup} if getattr(light_object, "lightgroup", "") else {"group": name}


def node_factor(tree, say):
    """(color, strength) that a light's or the world's nodes multiply with; None where there is no constant."""
    output = closures.output_of(tree)
    if output is None or not output.inputs["Surface"].is_linked:
        return (0.0, 0.0, 0.0), 0.0
    out, scope = closures.source(output.inputs["Surface"], closures.top())
    if out is None or not out.is_output or out.node.type not in ("EMISSION", "BACKGROUND"):
        say("its nodes are more than one Emission or Background; it is left out")
        return None
    color, strength = fold(socket(out.node, "Color"), scope), fold(socket(out.node, "Strength"), scope)
    varies = color.varies or strength.varies
    if varies:
        say(f"its light is not constant ({varies}), which is not built; it is left out")
        return None
    return color.color(), strength.number()


def scales(matrix):
    return [matrix.col[i].to_3d().length for i in range(3)]


def degrees(radians):
    """At most half a turn: in single precision pi is a little more than pi."""
    return min(round(math.degrees(radians), 5), 180.0)


def rows(matrix):
    return [[float(x) for x in row] for row in matrix]


def unscaled(matrix):
    """Without scale and mirroring, shining along the same -Z; None where an axis has no length."""
    x, y, z = (matrix.col[i].to_3d() for i in range(3))
    if min(x.length, y.length, z.length) < 1e-12:
        return None
    m = matrix.copy()
    z = z.normalized()
    x = (x - z * x.dot(z)).normalized()
    y = z.cross(x)
    for i, axis in enumerate((x, y, z)):
        m.col[i] = (*axis, 0.0)
    return m


def lamp(obj, matrix, name, say):
    """The light of the scene format; None for one that is left out (said)."""
    data = obj.data
    m = unscaled(matrix)
    if m is None:
        say("it is scaled to nothing; it is left out")
        return None
    strength = float(data.energy) * 2.0 ** float(getattr(data, "exposure", 0.0))
    color = [float(c) for c in data.color]
    if getattr(data, "use_temperature", False):
        color = [a * float(b) for a, b in zip(color, data.temperature_color)]
    if closures.tree_of(data):
        factor = node_factor(data.node_tree, say)
        if factor is None:
            return None
        color, strength = [a * b for a, b in zip(color, factor[0])], strength * factor[1]
    if strength < 0 or min(color) < 0:
        say("it has negative light, which nothing can focus; it is left out")
        return None
    if not getattr(data, "normalize", True):
        strength *= surface(data, scales(matrix))
    if not math.isfinite(strength * sum(color)):
        say("its power is not a finite number; it is left out")
        return None
    if data.type == "AREA" and getattr(data.cycles, "is_portal", False):
        return None
    peculiarities(obj, say)
    made = {"name": name, "matrix": rows(m), "color": color, **group_of(obj, obj.name)}
    return KINDS[data.type](data, made, strength, scales(matrix), say)


def peculiarities(obj, say):
    if not (obj.visible_glossy and obj.visible_transmission):
        say("it is hidden from glossy or transmission rays, which its caustics do not follow")
    if not getattr(obj.data.cycles, "cast_shadow", getattr(obj.data, "use_shadow", True)):
        say("it casts no shadows; its caustics are shadowed")
    linking = getattr(obj, "light_linking", None)
    if linking and (linking.receiver_collection or linking.blocker_collection):
        say("light linking is not built; it shines on everything")


def surface(data, size):
    """What Blender 4.5 on does not divide by where "Normalize" is off: the lamp's area, or a sun's share of the sky."""
    if data.type == "AREA":
        sides = size[0] * size[1] * data.size * (data.size if data.shape in ("SQUARE", "DISK") else data.size_y)
        return sides * (math.pi / 4 if data.shape in ("DISK", "ELLIPSE") else 1.0)
    if data.type == "SUN":
        return math.pi * math.sin(min(data.angle, math.pi) / 2) ** 2 or 1.0
    return 4 * (math.pi * data.shadow_soft_size**2 or 1.0)


def sun_factor(angle):
    """Irradiance per strength on a surface that faces it. 3.4 divides by tan^2 instead of sin^2 of the half angle and shines
    with 1 / cos^3 to the middle: the integral of both over the disc."""
    half = min(angle, math.radians(179.0)) / 2
    return 1.0 if NEW or half < 1e-3 else 2 * (1 / math.cos(half) - 1) / math.tan(half) ** 2


def sun(data, made, strength, size, say):
    strength *= sun_factor(data.angle)
    return {**made, "type": "sun", "strength": strength, "angle_deg": degrees(data.angle)}


def body(data):
    """Up to 3.x, and with Soft Falloff, lamps are disks that face what they light."""
    radius = float(data.shadow_soft_size)
    return {"radius_m": radius, **({"body": "disk"} if radius > 0 and getattr(data, "use_soft_falloff", True) else {})}


def point(data, made, strength, size, say):
    return {**made, "type": "point", "power_w": strength, **body(data)}


def spot(data, made, strength, size, say):
    if max(size) - min(size) > 1e-4 * max(size):
        say("the scale of its cone is left out; its cone is round")
    return {**made, "type": "spot", "power_w": strength, **body(data),
            "cone_deg": degrees(data.spot_size), "blend": float(data.spot_blend), **({"falloff": "none"} if NEW else {})}


AREA = 4 / math.pi if NEW else 1.0  # radiance P / (pi area) where it was P / (4 area)


def area(data, made, strength, size, say):
    x = float(data.size)
    y = x if data.shape in ("SQUARE", "DISK") else float(data.size_y)
    sides = [x * size[0], y * size[1]]
    if min(sides) <= 0:
        say("it has no area; it is left out")
        return None
    return {**made, "type": "area", "shape": "disk" if data.shape in ("DISK", "ELLIPSE") else "rectangle", "size": sides,
            "power_w": strength * AREA, "spread_deg": max(degrees(data.spread), 0.01)}


KINDS = {"SUN": sun, "POINT": point, "SPOT": spot, "AREA": area}


def world(item, say):
    """The world of the scene format; None where there is none or it is left out (said)."""
    if item is None:
        return None
    color, strength = [float(c) for c in item.color], 1.0
    if closures.tree_of(item):
        output = closures.output_of(item.node_tree)
        if output and output.inputs["Volume"].is_linked:
            say("its volume is not built; it is left out")
        factor = node_factor(item.node_tree, say)
        if factor is None:
            return None
        color, strength = list(factor[0]), factor[1]
    if strength <= 0 or max(color) <= 0:
        return None
    return {"color": [max(c, 0.0) for c in color], "strength": strength, "group": getattr(item, "lightgroup", "") or "world"}
