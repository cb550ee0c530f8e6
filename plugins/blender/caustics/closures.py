# SPDX-License-Identifier: Apache-2.0
"""A surface's node tree as a list of weighted closures."""
import bpy

from . import ggx
from .fold import Scope, Value, fold, socket, source


class Closure:
    """kind: diffuse, plastic, metal, glass, refraction, transparent, emission, other. weight: its share of the mix, a
    number. fresnel: the index of refraction of the Fresnel node that mixes it in, None otherwise."""

    def __init__(self, kind, params, weight=1.0, fresnel=None, name=""):
        self.kind, self.params, self.weight, self.fresnel, self.name = kind, params, weight, fresnel, name

    def scaled(self, weight, fresnel=None):
        return Closure(self.kind, self.params, self.weight * weight, fresnel or self.fresnel, self.name)


class Reader:
    """Reads one material. say(reason): called for everything that the result does not carry. baked: means of Baker."""

    def __init__(self, say, material="", baked=None):
        self.say, self.material, self.baked = say, material, baked or {}
        self.varying = []      # (node, identifier of its input) of what is not constant, outside groups
        self.textured = False  # a colour of a diffuse lobe varies over the surface
        self.tricks = []       # (material or group, its name, node, output) that let shadow or diffuse rays through
        self.plastics = []     # (Principled node, parameters) of those with a coat over a base

    def get(self, what, sock, scope):
        value = fold(sock, scope)
        if not value.varies or sock is None:
            return value
        mean = None
        if not scope.groups and not by_ray(sock, scope):
            self.varying.append((sock.node.name, sock.identifier))
            mean = self.baked.get((self.material, sock.node.name, sock.identifier))
        if mean is None:
            self.say(f"its {what} is not constant ({value.varies}); the mean stands in")
            return value
        words = ", ".join(f"{x:.3g}" for x in (mean if max(mean) - min(mean) > 1e-4 else mean[:1]))
        self.say(f"its {what} is not constant ({value.varies}); its mean over the surface, {words}, baked by Cycles, stands in")
        return Value(mean, value.varies)

    def color(self, what, sock, scope):
        c = self.get(what, sock, scope).color()
        if max(c) > 1 or min(c) < 0:
            self.say(f"its {what} is beyond 0 to 1 ({max(c):.3g}); it is cut there")
        return [min(max(x, 0.0), 1.0) for x in c]

    def albedo(self, sock, scope):
        """A colour of a diffuse lobe: what varies is for the Diffuse Color pass."""
        value = fold(sock, scope)
        if value.varies:
            self.textured = True
            self.say(f"its color is not constant ({value.varies}): direct caustics take it from the Diffuse Color pass; "
                     "its mean stands in for light that bounces on and for what is seen through glass")
        return [min(max(x, 0.0), 1.0) for x in value.color()]

    def number(self, what, sock, scope, low=0.0, high=1.0):
        return min(max(self.get(what, sock, scope).number(), low), high)

    def surface(self, sock, scope, depth=0):
        out, scope = source(sock, scope)
        if out is None or not out.is_output:
            return []
        reader = READERS.get(out.node.type)
        if depth > 100:
            self.say("its shaders are nested too deep")
            return []
        if not reader:
            self.say(f'shader node "{out.node.name}" is not built')
            return [Closure("other", {}, name=out.node.name)]
        return reader(self, out.node, scope, depth)

    def normals(self, node, scope):
        for name in ("Normal", "Coat Normal", "Clearcoat Normal"):
            s = socket(node, name)
            if s and s.is_linked:
                out, _ = source(s, scope)
                if out is not None and out.is_output and out.node.type not in ("NEW_GEOMETRY", "TEX_COORD"):
                    self.say("bump and normal maps are not built; it is taken as smooth")


RAYS = {"LIGHT_PATH", "FRESNEL", "LAYER_WEIGHT", "CAMERA"}  # nodes whose values are a ray's, not a place's


def by_ray(sock, scope, depth=0):
    out, scope = source(sock, scope)
    if out is None or not out.is_output:
        return False
    return out.node.type in RAYS or depth > 50 or any(by_ray(s, scope, depth + 1) for s in out.node.inputs)


def rough(reader, node, scope):
    if getattr(node, "distribution", "GGX") == "SHARP":
        return 0.0
    value = reader.number("roughness", socket(node, "Roughness"), scope)
    if value > 0 and node.distribution in ("BECKMANN", "ASHIKHMIN_SHIRLEY"):
        reader.say(f"{node.distribution.title()} roughness is rendered as GGX")
    return value


def metallic_color(reader, node, color, roughness):
    """The color with which the renderer's facets reflect as much as Blender's."""
    if roughness <= 0:
        return color
    multiscatter = getattr(node, "distribution", "GGX") == "MULTI_GGX"
    lifted = [c * ggx.gain(roughness, c, multiscatter, bpy.app.version >= (4, 0, 0)) for c in color]
    lost = 1 - min(1 / max(lifted), 1) if max(lifted) > 0 else 0
    if lost > 0.01:
        reader.say(f"its facets reflect {100 * lost:.0f} % less than in Blender, where light bounces among them")
    return [min(c, 1.0) for c in lifted]


def facets(reader, node, roughness):
    """Of glass: whether light that meets more than one of its facets is given back, as parameters."""
    if roughness <= 0 or getattr(node, "distribution", "GGX") != "MULTI_GGX":
        return {}
    if bpy.app.version < (4, 0, 0):
        reader.say("rough glass of Multiscatter GGX has darker caustics in Blender 3.x; it is rendered as GGX")
        return {}
    return {"facets": "multiple"}


def diffuse(reader, node, scope, depth):
    reader.normals(node, scope)
    r = socket(node, "Roughness")
    if r and reader.number("roughness", r, scope) > 0:
        reader.say("the roughness of a diffuse surface (Oren-Nayar) is left out")
    return [Closure("diffuse", {"color": reader.albedo(socket(node, "Color"), scope)}, name=node.name)]


def glossy(reader, node, scope, depth):
    reader.normals(node, scope)
    s = socket(node, "Anisotropy")
    if s and reader.number("anisotropy", s, scope, -1) != 0:
        reader.say("anisotropy is left out")
    color = reader.color("color", socket(node, "Color"), scope)
    roughness = rough(reader, node, scope)
    color = metallic_color(reader, node, color, roughness)
    return [Closure("metal", {"color": color, "edge_color": color, "roughness": roughness}, name=node.name)]


def metallic(reader, node, scope, depth):
    """The Metallic BSDF of 4.3 on, by its colors or by the index of refraction and extinction of each channel."""
    reader.normals(node, scope)
    for what, name in (("anisotropy", "Anisotropy"), ("the thin film", "Thin Film Thickness")):
        s = socket(node, name)
        if s and reader.number(what, s, scope, -1, 1e6) != 0:
            reader.say(f"{what} is left out")
    if node.fresnel_type == "F82":
        color = reader.color("color", socket(node, "Base Color"), scope)
        if min(reader.color("edge tint", socket(node, "Edge Tint"), scope)) < 1:
            reader.say("its edge tint is left out; it is brighter at grazing angles")
    else:
        n, k = (reader.get(name.lower(), socket(node, name), scope).color() for name in ("IOR", "Extinction"))
        color = [((a - 1) ** 2 + b * b) / ((a + 1) ** 2 + b * b) for a, b in zip(n, k)]
    roughness = rough(reader, node, scope)
    color = metallic_color(reader, node, color, roughness)
    return [Closure("metal", {"color": color, "edge_color": [1, 1, 1], "roughness": roughness}, name=node.name)]


def glass(reader, node, scope, depth):
    reader.normals(node, scope)
    ior = reader.number("index of refraction", socket(node, "IOR"), scope, 0.1, 10.0)
    params = {"color": reader.color("color", socket(node, "Color"), scope), "ior": ior, "roughness": rough(reader, node, scope)}
    params.update(facets(reader, node, params["roughness"]))
    return [Closure("refraction" if node.type == "BSDF_REFRACTION" else "glass", params, name=node.name)]


def transparent(reader, node, scope, depth):
    return [Closure("transparent", {"color": reader.color("color", socket(node, "Color"), scope)}, name=node.name)]


def emission(reader, node, scope, depth):
    strength = fold(socket(node, "Strength"), scope)
    if strength.varies or (strength.number() > 0 and max(fold(socket(node, "Color"), scope).color()) > 0):
        reader.say("it shines (Emission); caustics of shining meshes are not built")
    return [Closure("emission", {}, name=node.name)]


def fresnel_of(sock, scope):
    """The index of refraction where a mix goes by a Fresnel node, None otherwise."""
    out, scope = source(sock, scope)
    if out is None or not out.is_output:
        return None
    if out.node.type == "FRESNEL":
        ior = fold(out.node.inputs["IOR"], scope)
        return None if ior.varies else max(ior.number(), 1.0 + 1e-5)
    if out.node.type == "LAYER_WEIGHT" and out.name == "Fresnel":
        blend = fold(out.node.inputs["Blend"], scope)
        return None if blend.varies else 1 / max(1 - min(blend.number(), 0.99999), 1e-5)
    return None


def mix(reader, node, scope, depth):
    fac, a, b = node.inputs[:3]
    ior = fresnel_of(fac, scope)
    if ior:
        return [c.scaled(1.0, ior) for s in (a, b) for c in reader.surface(s, scope, depth + 1)]
    note_tricks(reader, fac, scope)
    w = reader.number("factor of a mix", fac, scope)
    made = []
    for s, share in ((a, 1 - w), (b, w)):
        if share > 0:
            made += [c.scaled(share) for c in reader.surface(s, scope, depth + 1)]
    return made


def note_tricks(reader, sock, scope, depth=0):
    """Remembers each link from Light Path that lets shadow or diffuse rays through."""
    out, inner = source(sock, scope)
    if out is None or not out.is_output or depth > 20 or out.node.get("caustics_base"):  # ours, of bases.py
        return
    if out.node.type == "LIGHT_PATH":
        if out.name in ("Is Shadow Ray", "Is Diffuse Ray"):
            tree = out.node.id_data
            where = ("material", reader.material) if tree.is_embedded_data else ("group", tree.name)
            reader.tricks.append((*where, out.node.name, out.name))
        return
    if out.node.type in ("MATH", "MIX_RGB", "MIX", "INVERT"):
        for s in out.node.inputs:
            note_tricks(reader, s, inner, depth + 1)


def add(reader, node, scope, depth):
    made = [c for s in node.inputs[:2] for c in reader.surface(s, scope, depth + 1)]
    return made


def principled(reader, node, scope, depth):
    reader.normals(node, scope)
    p = Principled(reader, node, scope)
    p.say_left_out()
    alpha = p.number("Alpha", default=1.0)
    metallic = p.number("Metallic")
    glassy = p.number("Transmission Weight", "Transmission") * (1 - metallic)
    rest = (1 - metallic) * (1 - p.number("Transmission Weight", "Transmission"))
    made = []
    if alpha < 1:
        made.append(Closure("transparent", {"color": [1, 1, 1]}, 1 - alpha, name=node.name))
    for share, make in ((metallic, p.metal), (glassy, p.glass), (rest, p.plastic)):
        if share * alpha > 0:
            made.append(make().scaled(share * alpha))
    return made


class Principled:
    """The Principled BSDF of 3.x and, since 4.0, of other names and other physics."""

    def __init__(self, reader, node, scope):
        self.reader, self.node, self.scope = reader, node, scope
        self.new = bpy.app.version >= (4, 0, 0)

    def number(self, *names, default=0.0, high=1.0):
        s = socket(self.node, *names)
        return self.reader.number(names[0].lower(), s, self.scope, 0.0, high) if s else default

    def base(self):
        return socket(self.node, "Base Color")

    def say_left_out(self):
        for what, names in (("subsurface scattering", ("Subsurface Weight", "Subsurface")), ("sheen", ("Sheen Weight", "Sheen")),
                            ("the clear coat", ("Coat Weight", "Clearcoat")), ("anisotropy", ("Anisotropic",)),
                            ("the thin film", ("Thin Film Thickness",)), ("the thin wall", ("Thin Wall",)),
                            ("the roughness of its base (Oren-Nayar)", ("Diffuse Roughness",))):
            if self.number(*names) > 0:
                self.reader.say(f"{what} is left out")
        tint = socket(self.node, "Specular Tint")
        plain = (1.0, 1.0, 1.0) if self.new else (0.0, 0.0, 0.0)
        if tint and fold(tint, self.scope).color() != plain:
            self.reader.say("the specular tint is left out")
        strength, color = socket(self.node, "Emission Strength"), socket(self.node, "Emission Color", "Emission")
        shines = (strength is None or fold(strength, self.scope).number() > 0) and color and max(fold(color, self.scope).color()) > 0
        if shines:
            self.reader.say("it shines (Emission); caustics of shining meshes are not built")

    def metal(self):
        color = self.reader.color("color", self.base(), self.scope)
        roughness = self.number("Roughness")
        color = metallic_color(self.reader, self.node, color, roughness)
        return Closure("metal", {"color": color, "edge_color": [1, 1, 1], "roughness": roughness}, name=self.node.name)

    def glass(self):
        color = self.reader.color("color", self.base(), self.scope)
        if self.new:  # tinted once per crossing of the body, not of each face (source: Blender manual, Principled BSDF)
            color = [c**0.5 for c in color]
        ior, roughness = self.reader.number("index of refraction", socket(self.node, "IOR"), self.scope, 0.1, 10.0), self.number("Roughness")
        return Closure("glass", {"color": color, "ior": ior, "roughness": roughness, **facets(self.reader, self.node, roughness)}, name=self.node.name)

    def plastic(self):
        color = self.reader.albedo(self.base(), self.scope)
        specular = self.number("Specular IOR Level", "Specular", high=1e6)
        if self.new:  # twice the reflectance of the index of refraction at level 1; the format counts in 0.08
            ior = self.reader.number("index of refraction", socket(self.node, "IOR"), self.scope, 1.0, 1e3)
            specular = 2 * specular * ((ior - 1) / (ior + 1)) ** 2 / 0.08
        if specular > 1:
            self.reader.say(f"its specular level reflects more ({0.08 * specular:.3g} straight on) than 0.08, the most that is built")
        if specular <= 0 and self.new:
            return Closure("diffuse", {"color": color}, name=self.node.name)
        params = {"color": color, "roughness": self.number("Roughness"), "specular": min(max(specular, 0.0), 1.0), "fresnel": "dielectric"}
        if not self.new:
            params["base"] = "burley"
        self.reader.plastics.append((self.node, params))
        return Closure("plastic", params, name=self.node.name)


READERS = {
    "BSDF_DIFFUSE": diffuse, "BSDF_GLOSSY": glossy, "BSDF_ANISOTROPIC": glossy, "BSDF_METALLIC": metallic, "BSDF_GLASS": glass, "BSDF_REFRACTION": glass,
    "BSDF_TRANSPARENT": transparent, "EMISSION": emission, "MIX_SHADER": mix, "ADD_SHADER": add, "BSDF_PRINCIPLED": principled,
}


def tree_of(owner):
    """The node tree of a material, world or light; None where it does without (5.0 on, all but lights have one)."""
    return owner.node_tree if getattr(owner, "use_nodes", True) else None


def output_of(tree):
    """The output node that Cycles takes."""
    outputs = [n for n in tree.nodes if n.type in ("OUTPUT_MATERIAL", "OUTPUT_WORLD", "OUTPUT_LIGHT") and not n.mute]
    outputs = [n for n in outputs if n.target in ("ALL", "CYCLES")]
    active = [n for n in outputs if n.is_active_output]
    best = [n for n in active if n.target == "CYCLES"] or active or outputs
    return best[0] if best else None


def top():
    return Scope()
