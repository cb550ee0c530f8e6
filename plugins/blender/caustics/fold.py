# SPDX-License-Identifier: Apache-2.0
"""Node sockets as constants, where they are.

A Value is what a socket gives everywhere on the surface. What varies over it (a texture, a vertex colour, the angle of
view) is a Value with a reason, and a mean that stands in where one number is needed."""
import colorsys
import math

DEPTH_MAX = 200  # node trees are not cyclic, but hostile ones may be deep


class Value:
    __slots__ = ("data", "varies")

    def __init__(self, data, varies=None):
        self.data, self.varies = data, varies

    def number(self):
        d = self.data
        return float(d) if isinstance(d, (int, float)) else 0.2126 * d[0] + 0.7152 * d[1] + 0.0722 * d[2]

    def color(self):
        d = self.data
        return (float(d),) * 3 if isinstance(d, (int, float)) else tuple(float(x) for x in d[:3])


class Scope:
    """A place in nested node groups: the group nodes that were entered."""

    def __init__(self, groups=()):
        self.groups = groups


def socket(node, *names):
    """The first input of these names or identifiers that is in use; Blender has renamed many."""
    for name in names:
        for s in node.inputs:
            if s.enabled and name in (s.name, s.identifier):
                return s
    return None


def source(sock, scope, depth=0):
    """The output that feeds this input, through reroutes, muted nodes and groups: (socket, scope).
    Where nothing feeds it: (the input whose own value counts, scope)."""
    while depth < DEPTH_MAX:
        depth += 1
        links = [l for l in sock.links if l.is_valid and not l.is_muted]
        if not links:
            return sock, scope
        out = links[0].from_socket
        node = out.node
        if node.mute:
            inner = [l.from_socket for l in node.internal_links if l.to_socket == out]
            if not inner:
                return None, scope
            sock = inner[0]
        elif node.type == "REROUTE":
            sock = node.inputs[0]
        elif node.type == "GROUP" and node.node_tree:
            inside = [n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output]
            found = [s for s in inside[0].inputs if s.identifier == out.identifier] if inside else []
            if not found:
                return None, scope
            sock, scope = found[0], Scope((*scope.groups, node))
        elif node.type == "GROUP_INPUT" and scope.groups:
            outer = scope.groups[-1]
            found = [s for s in outer.inputs if s.identifier == out.identifier]
            if not found:
                return None, scope
            sock, scope = found[0], Scope(scope.groups[:-1])
        else:
            return out, scope
    return None, scope


def plain(value):
    return tuple(value) if hasattr(value, "__len__") else value


def fold(sock, scope, depth=0):
    """The Value of an input socket."""
    if sock is None:
        return Value(0.0, "a socket is missing")
    out, scope = source(sock, scope)
    if out is None:
        return Value(0.0)
    if not out.is_output:
        return Value(plain(getattr(out, "default_value", 0.0)))
    if depth > DEPTH_MAX:
        return Value(0.0, "its nodes are nested too deep")
    folder = FOLDERS.get(out.node.type)
    if folder:
        return folder(out.node, out, lambda s: fold(s, scope, depth + 1))
    return Value(0.5, f'node "{out.node.name}" varies over the surface')


def joined(values, data):
    return Value(data, next((v.varies for v in values if v.varies), None))


# ---- nodes with a value --------------------------------------------------------------------------------------------

def own_output(node, out, get):
    return Value(plain(node.outputs[0].default_value))


def mean_of_image(node, out, get):
    image = node.image
    if out.name == "Alpha" or image is None or not image.size[0]:
        return Value(1.0 if out.name == "Alpha" else (0.5, 0.5, 0.5), f'texture "{node.name}"')
    return Value(image_mean(image), f'texture "{image.name}"')


def image_mean(image):
    """Of an image in scene-linear RGB; sRGB files are linearised (IEC 61966-2-1)."""
    import numpy as np
    try:
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
    except (RuntimeError, TypeError, MemoryError):
        return (0.5, 0.5, 0.5)
    if not len(pixels):
        return (0.5, 0.5, 0.5)
    rgb = pixels.reshape(-1, max(image.channels, 1))
    rgb = rgb[:, :3] if rgb.shape[1] >= 3 else np.repeat(rgb[:, :1], 3, axis=1)
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        rgb = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return tuple(float(x) for x in np.nan_to_num(rgb.mean(axis=0)))


def blackbody(node, out, get):
    """As Blender's colour of a black body, by Planck's locus: Kim et al. 2002, US patent 7024034, to XYZ, to Rec.709."""
    v = get(node.inputs[0])
    t = min(max(v.number(), 1667.0), 25000.0)
    if t <= 4000:
        x = -0.2661239e9 / t**3 - 0.2343589e6 / t**2 + 0.8776956e3 / t + 0.179910
    else:
        x = -3.0258469e9 / t**3 + 2.1070379e6 / t**2 + 0.2226347e3 / t + 0.240390
    if t <= 2222:
        y = -1.1063814 * x**3 - 1.34811020 * x**2 + 2.18555832 * x - 0.20219683
    elif t <= 4000:
        y = -0.9549476 * x**3 - 1.37418593 * x**2 + 2.09137015 * x - 0.16748867
    else:
        y = 3.0817580 * x**3 - 5.87338670 * x**2 + 3.75112997 * x - 0.37001483
    big_x, big_z = x / y, (1 - x - y) / y
    rgb = (3.2404542 * big_x - 1.5371385 - 0.4985314 * big_z, -0.9692660 * big_x + 1.8760108 + 0.0415560 * big_z,
           0.0556434 * big_x - 0.2040259 + 1.0572252 * big_z)
    return joined([v], tuple(max(c, 0.0) for c in rgb))


def power(a, b):
    try:
        r = math.pow(a, b)
        return r if math.isfinite(r) else 0.0
    except (ValueError, OverflowError):
        return 0.0


MATH = {
    "ADD": lambda a, b, c: a + b, "SUBTRACT": lambda a, b, c: a - b, "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: a / b if b else 0.0, "MULTIPLY_ADD": lambda a, b, c: a * b + c, "POWER": lambda a, b, c: power(a, b),
    "LOGARITHM": lambda a, b, c: math.log(a) / math.log(b) if a > 0 and b > 0 and b != 1 else 0.0,
    "SQRT": lambda a, b, c: math.sqrt(a) if a > 0 else 0.0, "INVERSE_SQRT": lambda a, b, c: 1 / math.sqrt(a) if a > 0 else 0.0,
    "ABSOLUTE": lambda a, b, c: abs(a), "EXPONENT": lambda a, b, c: math.exp(min(a, 80.0)),
    "MINIMUM": lambda a, b, c: min(a, b), "MAXIMUM": lambda a, b, c: max(a, b),
    "LESS_THAN": lambda a, b, c: float(a < b), "GREATER_THAN": lambda a, b, c: float(a > b),
    "SIGN": lambda a, b, c: float((a > 0) - (a < 0)), "COMPARE": lambda a, b, c: float(abs(a - b) <= max(c, 1e-5)),
    "ROUND": lambda a, b, c: math.floor(a + 0.5), "FLOOR": lambda a, b, c: math.floor(a), "CEIL": lambda a, b, c: math.ceil(a),
    "TRUNC": lambda a, b, c: math.trunc(a), "FRACT": lambda a, b, c: a - math.floor(a),
    "MODULO": lambda a, b, c: math.fmod(a, b) if b else 0.0, "SINE": lambda a, b, c: math.sin(a), "COSINE": lambda a, b, c: math.cos(a),
    "TANGENT": lambda a, b, c: math.tan(a), "RADIANS": lambda a, b, c: math.radians(a), "DEGREES": lambda a, b, c: math.degrees(a),
}


def math_node(node, out, get):
    values = [get(s) for s in node.inputs if s.enabled]
    a, b, c = ([v.number() for v in values] + [0.0] * 3)[:3]
    if node.operation not in MATH:
        return Value(a, f'node "{node.name}" does what is not followed here')
    if node.operation == "MULTIPLY" and any(v.number() == 0 and not v.varies for v in values):
        return Value(0.0)
    r = MATH[node.operation](a, b, c)
    return joined(values, min(max(r, 0.0), 1.0) if node.use_clamp else float(r))


VECTOR = {
    "ADD": lambda x, y: x + y, "SUBTRACT": lambda x, y: x - y, "MULTIPLY": lambda x, y: x * y,
    "DIVIDE": lambda x, y: x / y if y else 0.0, "MINIMUM": min, "MAXIMUM": max,
}


def vector_math(node, out, get):
    values = [get(s) for s in node.inputs if s.enabled]
    if node.operation == "SCALE":
        return joined(values, tuple(x * values[-1].number() for x in values[0].color()))
    if node.operation not in VECTOR:
        return Value(values[0].color(), f'node "{node.name}" does what is not followed here')
    return joined(values, tuple(VECTOR[node.operation](x, y) for x, y in zip(values[0].color(), values[1].color())))


BLEND = {
    "MIX": lambda a, b: b, "ADD": lambda a, b: a + b, "SUBTRACT": lambda a, b: a - b, "MULTIPLY": lambda a, b: a * b,
    "DIVIDE": lambda a, b: a / b if b else a, "SCREEN": lambda a, b: 1 - (1 - a) * (1 - b), "DIFFERENCE": lambda a, b: abs(a - b),
    "DARKEN": min, "LIGHTEN": max, "OVERLAY": lambda a, b: 2 * a * b if a < 0.5 else 1 - 2 * (1 - a) * (1 - b),
}


def mix_rgb(node, out, get):
    return blend(node, [get(s) for s in node.inputs if s.enabled][:3], node.use_clamp)


def mix_new(node, out, get):
    """The Mix node of 3.4 and later: float, vector or colour by the sockets in use."""
    values = [get(s) for s in node.inputs if s.enabled][:3]
    if node.clamp_factor:
        values[0] = Value(min(max(values[0].number(), 0.0), 1.0), values[0].varies)
    if node.data_type == "RGBA":
        return blend(node, values, node.clamp_result)
    f, a, b = values
    if node.data_type == "FLOAT":
        return joined(values, a.number() + f.number() * (b.number() - a.number()))
    return joined(values, tuple(x + f.number() * (y - x) for x, y in zip(a.color(), b.color())))


def blend(node, values, clamp):
    f, a, b = values
    if node.blend_type not in BLEND:
        return Value(a.color(), f'node "{node.name}" does what is not followed here')
    w = min(max(f.number(), 0.0), 1.0)
    mixed = tuple(x + w * (BLEND[node.blend_type](x, y) - x) for x, y in zip(a.color(), b.color()))
    return joined(values, tuple(min(max(x, 0.0), 1.0) for x in mixed) if clamp else mixed)


def invert(node, out, get):
    f, c = get(node.inputs[0]), get(node.inputs[1])
    return joined([f, c], tuple(x + f.number() * (1 - 2 * x) for x in c.color()))


def gamma(node, out, get):
    c, g = get(node.inputs[0]), get(node.inputs[1])
    return joined([c, g], tuple(power(x, g.number()) if x > 0 else x for x in c.color()))


def bright_contrast(node, out, get):
    c, bright, contrast = (get(s) for s in node.inputs[:3])
    a, b = 1 + contrast.number(), bright.number() - contrast.number() / 2
    return joined([c, bright, contrast], tuple(max(a * x + b, 0.0) for x in c.color()))


def hue_saturation(node, out, get):
    hue, sat, val, fac, c = (get(s) for s in node.inputs[:5])
    h, s, v = colorsys.rgb_to_hsv(*[max(x, 0.0) for x in c.color()])
    turned = colorsys.hsv_to_rgb((h + hue.number() + 0.5) % 1.0, min(max(s * sat.number(), 0.0), 1.0), v * val.number())
    w = fac.number()
    return joined([hue, sat, val, fac, c], tuple(max(x + w * (y - x), 0.0) for x, y in zip(c.color(), turned)))


def combine(node, out, get):
    values = [get(s) for s in node.inputs[:3]]
    if getattr(node, "mode", "RGB") != "RGB":
        data = {"HSV": colorsys.hsv_to_rgb, "HSL": lambda h, s, l: colorsys.hls_to_rgb(h, l, s)}[node.mode](*[v.number() for v in values])
        return joined(values, data)
    return joined(values, tuple(v.number() for v in values))


def separate(node, out, get):
    v = get(node.inputs[0])
    rgb = v.color()
    mode = getattr(node, "mode", "RGB")
    if mode != "RGB":
        h, s, l = colorsys.rgb_to_hsv(*rgb) if mode == "HSV" else [colorsys.rgb_to_hls(*rgb)[i] for i in (0, 2, 1)]
        rgb = (h, s, l)
    return Value(rgb[[s.identifier for s in node.outputs].index(out.identifier)], v.varies)


def clamp(node, out, get):
    v, lo, hi = (get(s) for s in node.inputs[:3])
    return joined([v, lo, hi], min(max(v.number(), lo.number()), hi.number()))


def map_range(node, out, get):
    if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
        return Value(0.5, f'node "{node.name}" does what is not followed here')
    values = [get(s) for s in node.inputs if s.enabled][:5]
    v, a, b, c, d = (x.number() for x in values)
    r = c + (v - a) / (b - a) * (d - c) if a != b else 0.0
    if node.clamp:
        r = min(max(r, min(c, d)), max(c, d))
    return joined(values, r)


def ramp(node, out, get):
    v = get(node.inputs[0])
    c = node.color_ramp.evaluate(v.number())
    return Value(c[3] if out.name == "Alpha" else tuple(c[:3]), v.varies)


def to_grey(node, out, get):
    v = get(node.inputs[0])
    return Value(v.number(), v.varies)


def light_path(node, out, get):
    """Shadow rays do not pass and diffuse rays see what others see: these are tricks against missing caustics, which
    the layers make up for. The rest has no constant."""
    if out.name in ("Is Shadow Ray", "Is Diffuse Ray"):
        return Value(0.0)
    return Value(1.0 if out.name == "Is Camera Ray" else 0.0, f'output "{out.name}" of "{node.name}"')


FOLDERS = {
    "RGB": own_output, "VALUE": own_output, "TEX_IMAGE": mean_of_image, "BLACKBODY": blackbody, "MATH": math_node,
    "VECT_MATH": vector_math, "MIX_RGB": mix_rgb, "MIX": mix_new, "INVERT": invert, "GAMMA": gamma, "BRIGHTCONTRAST": bright_contrast,
    "HUE_SAT": hue_saturation, "COMBRGB": combine, "COMBINE_COLOR": combine, "COMBXYZ": combine, "SEPRGB": separate,
    "SEPARATE_COLOR": separate, "SEPXYZ": separate, "CLAMP": clamp, "MAP_RANGE": map_range, "VALTORGB": ramp, "RGBTOBW": to_grey,
    "LIGHT_PATH": light_path,
}
