# SPDX-License-Identifier: Apache-2.0
"""Cycles materials as materials of the scene format."""
from . import closures

DEFAULT = {"type": "diffuse", "color": [0.8, 0.8, 0.8]}  # Cycles' own where an object has none
BLACK = {"type": "diffuse", "color": [0.0, 0.0, 0.0]}


class Materials:
    """Those in use, by name, as they are met. notes: a Notes. textured: names of those whose colour is for the Diffuse
    Color pass. baked: means of Baker."""

    def __init__(self, notes, baked=None):
        self.notes, self.baked, self.items, self.textured = notes, baked, {}, set()

    def name_of(self, material):
        name = material.name_full if material else "(none)"
        if name not in self.items:
            self.items[name] = self.read(material, name) if material else dict(DEFAULT)
        return name

    def read(self, material, name):
        def say(reason):
            self.notes.add(f'Material "{name}"', reason)

        if not closures.tree_of(material):
            return {"type": "diffuse", "color": [min(max(c, 0.0), 1.0) for c in material.diffuse_color[:3]]}
        output = closures.output_of(material.node_tree)
        if output is None:
            return dict(BLACK)
        if output.inputs["Volume"].is_linked:
            say("volumes and absorption are not built; only its surface takes part")
        self.displacement(material, output, say)
        reader = closures.Reader(say, name, self.baked)
        made = to_format(reader.surface(output.inputs["Surface"], closures.top()), say)
        if reader.textured:
            self.textured.add(name)
        return made

    @staticmethod
    def displacement(material, output, say):
        if not output.inputs["Displacement"].is_linked:
            return
        method = getattr(material, "displacement_method", None) or material.cycles.displacement_method
        say("bump is not built; it is taken as smooth" if method == "BUMP" else
            "displacement by the shader is not built; use a Displace modifier")


def to_format(found, say):
    """The material of the scene format for a list of closures."""
    solid = [c for c in found if c.kind not in ("emission", "other")]
    if not solid:
        return dict(BLACK)
    layered = fresnel_pair(solid, say)
    if layered:
        return layered
    if any(c.fresnel for c in solid):
        say("a mix by the angle of view that is not built: " + " and ".join(sorted({c.kind for c in solid})))
    merged = merge(solid)
    if len(merged) == 1:
        return finish(merged[0], min(merged[0].weight, 1.0), say)
    best = max(merged, key=lambda c: c.weight * max(c.params["color"]))
    say(f"a mix of {' and '.join(c.kind for c in merged)} is not built; {best.kind} stands in for all of it")
    return finish(best, 1.0, say)


def same(a, b):
    keys = ("roughness", "ior", "specular", "fresnel", "base", "facets")
    return a.kind == b.kind and all(a.params.get(k) == b.params.get(k) for k in keys)


def merge(found):
    """Closures that differ in color only are one."""
    groups = []
    for c in found:
        group = next((g for g in groups if same(g[0], c)), None)
        group.append(c) if group else groups.append([c])
    return [average(g) for g in groups]


def average(group):
    total = sum(c.weight for c in group)
    if len(group) == 1 or total <= 0:
        return group[0]
    params = dict(group[0].params)
    for key in ("color", "edge_color"):
        if key in params:
            params[key] = [sum(c.weight * c.params[key][i] for c in group) / total for i in range(3)]
    return closures.Closure(group[0].kind, params, total, name=group[0].name)


def fresnel_pair(found, say):
    """The two mixes by a Fresnel node that everybody builds: a coat over diffuse, and glass by hand."""
    kinds = {c.kind: c for c in found}
    if len(found) != 2 or len(kinds) != 2 or not all(c.fresnel for c in found):
        return None
    metal, ior = kinds.get("metal"), found[0].fresnel
    if metal and "refraction" in kinds:
        inner = kinds["refraction"].params
        if abs(inner["ior"] - ior) > 1e-3 or abs(inner["roughness"] - metal.params["roughness"]) > 1e-3:
            say("glass of two indices of refraction or roughnesses is not built; those of its refraction count")
        return {"type": "glass", **inner}
    if metal and "diffuse" in kinds:
        f0 = ((ior - 1) / (ior + 1)) ** 2
        if f0 > 0.08 or min(metal.params["color"]) < 0.999:
            say("a coat that is colored or reflects more than 0.08 straight on is not built; the nearest stands in")
        return {"type": "plastic", "color": kinds["diffuse"].params["color"], "roughness": metal.params["roughness"],
                "specular": min(f0 / 0.08, 1.0), "fresnel": "dielectric"}
    return None


def finish(closure, weight, say):
    params = dict(closure.params)
    kind = closure.kind
    if kind == "refraction":
        kind = "glass"
        say("refraction without reflection is not built; glass stands in")
    for key in ("color", "edge_color"):
        if key in params:
            params[key] = [min(c * weight, 1.0) for c in params[key]]
    return {"type": kind, **params}
