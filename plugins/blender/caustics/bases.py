# SPDX-License-Identifier: Apache-2.0
"""The base of Blender's Principled BSDF behind diffuse rays, with caustics off.

From 4.0 on the base gets what the coat leaves, and caustics off drop the coat behind a diffuse ray: the base is then bright
as if it had no coat, and the picture lighter than caustics on by what the coats of all walls hold back (2.6 % in a room of
plastic). No layer of light could take that away. So while the add-on renders its picture, Base Color times
1 - E for diffuse rays alone, E being what the coat reflects in all, by nodes that go away again."""
import bpy

from . import closures, ggx
from .fold import socket

MARK = "caustics_base"  # property of the nodes that stand in a tree meanwhile
STOPS = 32              # what a color ramp holds


def needed():
    return bpy.app.version >= (4, 0, 0)


# ---- what a coat reflects ------------------------------------------------------------------------------------------------

def dielectric(cos, ior):
    """Fresnel's reflectance."""
    import numpy as np
    g = np.sqrt(np.maximum(ior * ior - 1 + cos * cos, 0))
    a, b = (g - cos) / (g + cos), (cos * (g + cos) - 1) / (cos * (g - cos) + 1)
    return 0.5 * a * a * (1 + b * b)


def ior_of(f0):
    root = min(f0, 0.999) ** 0.5
    return (1 + root) / (1 - root)


class Coat:
    """What a GGX coat reflects of light from a direction, as Cycles counts it where it layers: all that its facets do not
    transmit; or, by Multiscatter GGX, what leaves them at once and what bounces among them (Kulla and Conty 2017)."""

    def __init__(self, roughness, f0, multiscatter):
        import numpy as np
        self.alpha, self.ior, self.multiscatter = ggx.alpha_of(roughness), ior_of(f0), multiscatter
        if multiscatter:
            cos = (np.arange(ggx.MEANS) + 0.5) / ggx.MEANS
            self.bounced = ggx.bounced(2 * np.mean(cos * dielectric(cos, self.ior)), ggx.mirror(roughness)[0])

    def lobe(self, cos):
        """(of a perfect mirror's facets, of these) the share that leaves at once."""
        c, leaves, _ = ggx.lobe(cos, self.alpha)
        return float(leaves.mean()), float((leaves * dielectric(c, self.ior)).mean())

    def reflected(self, cos):
        mirror, once = self.lobe(cos)
        if not self.multiscatter:
            return once / mirror
        return once * (1 + self.bounced * (1 - mirror) / mirror)


# ---- the nodes -----------------------------------------------------------------------------------------------------------

class Base:
    """A Principled node with a coat over its base. tree: (material or group, its name)."""

    def __init__(self, tree, node, coat):
        self.tree, self.node, self.coat = tree, node, coat


def found(notes=None):
    """[Base] of all materials of the file, each node once; a group's with the values of its first user."""
    made = {}
    for material in bpy.data.materials:
        output = closures.output_of(material.node_tree) if closures.tree_of(material) else None
        if output is None:
            continue
        reader = closures.Reader(lambda reason: None, material.name)
        reader.surface(output.inputs["Surface"], closures.top())
        for node, params in reader.plastics:
            tree = node.id_data
            where = ("material", material.name) if tree.is_embedded_data else ("group", tree.name)
            if (material if tree.is_embedded_data else tree).library:
                if notes is not None:
                    notes.append(f'Material "{material.name}": it is linked, so the picture has its base too bright where it lights others')
            else:
                coat = Coat(params["roughness"], 0.08 * params["specular"], node.distribution == "MULTI_GGX")
                made.setdefault((*where, node.name), Base(where, node.name, coat))
    return list(made.values())


def tree_of(where):
    kind, name = where
    return bpy.data.materials[name].node_tree if kind == "material" else bpy.data.node_groups[name]


def add(tree, kind, **values):
    node = tree.nodes.new(kind)
    node[MARK] = 1
    for key, value in values.items():
        setattr(node, key, value)
    return node


def facing(tree, normal):
    """The cosine between the normal and the eye."""
    geometry, dot = add(tree, "ShaderNodeNewGeometry"), add(tree, "ShaderNodeVectorMath", operation="DOT_PRODUCT")
    tree.links.new(normal or geometry.outputs["Normal"], dot.inputs[0])
    tree.links.new(geometry.outputs["Incoming"], dot.inputs[1])
    return dot.outputs["Value"]


def held_back(tree, cos, base):
    """E by the cosine; closer stops at grazing angles, where it is steep."""
    ramp = add(tree, "ShaderNodeValToRGB")
    tree.links.new(cos, ramp.inputs[0])
    elements = ramp.color_ramp.elements
    places = [(i / (STOPS - 1)) ** 2 for i in range(STOPS)]
    for place in places[1:-1]:
        elements.new(place)
    for element, place in zip(elements, places):
        element.position = place
        e = base.coat.reflected(max(place, 1e-3))
        element.color = (e, e, e, 1)
    return ramp.outputs["Color"]


def math(tree, operation, a, b):
    node = add(tree, "ShaderNodeMath", operation=operation)
    for sock, value in zip(node.inputs, (a, b)):
        if isinstance(value, float):
            sock.default_value = value
        else:
            tree.links.new(value, sock)
    return node.outputs[0]


def dim(base):
    """Before the color. A color that may be animated stays at its socket, or its keys would not count: then behind the
    whole shader, whose base is all that diffuse rays see of it but for alpha and emission."""
    tree = tree_of(base.tree)
    node = tree.nodes[base.node]
    color, normal = socket(node, "Base Color"), socket(node, "Normal")
    cos = facing(tree, normal.links[0].from_socket if normal and normal.is_linked else None)
    rays = add(tree, "ShaderNodeLightPath")
    lost = math(tree, "MULTIPLY", rays.outputs["Is Diffuse Ray"], held_back(tree, cos, base))
    if tree.animation_data and not color.is_linked:
        behind(tree, node, lost)
        return
    scale = add(tree, "ShaderNodeVectorMath", operation="SCALE")
    if color.is_linked:
        tree.links.new(color.links[0].from_socket, scale.inputs[0])
    else:
        scale.inputs[0].default_value = color.default_value[:3]
    tree.links.new(math(tree, "SUBTRACT", 1.0, lost), scale.inputs["Scale"])
    tree.links.new(scale.outputs[0], color)


def behind(tree, node, lost):
    mix = add(tree, "ShaderNodeMixShader")
    for to in [link.to_socket for link in node.outputs[0].links]:
        tree.links.new(mix.outputs[0], to)
    tree.links.new(lost, mix.inputs[0])
    tree.links.new(node.outputs[0], mix.inputs[1])


THROUGH = {"ShaderNodeVectorMath": 0, "ShaderNodeMixShader": 1}  # which input of ours stood where our output stands


def restore(where):
    """Takes our nodes out of a tree; needs nothing but the tree, so that it works on a file that was saved meanwhile."""
    tree = tree_of(where)
    ours = [n for n in tree.nodes if n.get(MARK)]
    for node in ours:
        for to in [link.to_socket for link in node.outputs[0].links if not link.to_node.get(MARK)]:
            before = node.inputs[THROUGH[node.bl_idname]]
            if before.is_linked:
                tree.links.new(before.links[0].from_socket, to)
    for node in ours:
        tree.nodes.remove(node)


def trees():
    """(material or group, name) of all that have nodes of ours."""
    made = [("material", m.name) for m in bpy.data.materials if closures.tree_of(m)]
    made += [("group", g.name) for g in bpy.data.node_groups]
    return [where for where in made if any(n.get(MARK) for n in tree_of(where).nodes)]
