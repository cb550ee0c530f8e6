# SPDX-License-Identifier: Apache-2.0
"""Settings of the scene that are changed for a while, and put back whatever happens."""
import bpy

from . import bases, closures


class Switches:
    """Remembers each value before it is set. Values are addressed by name, not by reference: undo replaces data."""

    def __init__(self, scene):
        self.scene = scene.name
        self.kept, self.links, self.dimmed = [], [], []

    def at(self, path):
        owner = bpy.data.scenes[self.scene]
        for step in path:
            owner = owner[step] if isinstance(owner, bpy.types.bpy_prop_collection) else getattr(owner, step)
        return owner

    def set(self, path, name, value):
        owner = self.at(path)
        old = getattr(owner, name)
        if old != value:
            setattr(owner, name, value)
            self.kept.append((path, name, old))

    def keep(self, path, names):
        """Remembers values that setting another changes, as a file format its color depth. Put back in this order."""
        owner = self.at(path)
        self.kept += [(path, name, getattr(owner, name)) for name in reversed(names) if hasattr(owner, name)]

    def caustics_off(self):
        """Without these MNEE's shadow caustics make nothing either (measured), so its flags can stay."""
        self.set(("cycles",), "caustics_reflective", False)
        self.set(("cycles",), "caustics_refractive", False)

    def cut_tricks(self):
        """Links from Light Path that let shadow rays through glass: with the layers they would count its light twice."""
        for trick in tricks_of(bpy.data.scenes[self.scene]):
            tree, (kind, name, node, output) = tree_of(trick), trick
            for link in list(tree.nodes[node].outputs[output].links):
                self.cut((kind, name), tree, link)

    def dim_bases(self):
        """Principled of 4.0 on: without this the picture has light that caustics on do not have (bases.py). Returns notes."""
        notes = []
        if bases.needed():
            self.restore_bases(bases.trees())
            for base in bases.found(notes):
                self.dimmed.append(base.tree)
                bases.dim(base)
        return notes

    @staticmethod
    def restore_bases(places):
        for where in dict.fromkeys(places):
            bases.restore(where)

    def cut(self, where, tree, link):
        to, sockets = link.to_socket, link.to_node.inputs
        at = [s.as_pointer() for s in sockets].index(to.as_pointer())
        old = to.default_value if isinstance(getattr(to, "default_value", None), float) else None
        self.links.append((where, link.from_node.name, link.from_socket.name, link.to_node.name, at, old))
        tree.links.remove(link)
        if old is not None:
            to.default_value = 0.0

    def restore(self):
        if self.scene in bpy.data.scenes:
            for path, name, old in reversed(self.kept):
                setattr(self.at(path), name, old)
        for where, node, output, into, at, old in reversed(self.links):
            tree = tree_of(where)
            to = tree.nodes[into].inputs[at]
            if old is not None:
                to.default_value = old
            tree.links.new(tree.nodes[node].outputs[output], to)
        self.kept, self.links = [], []
        self.restore_bases(self.dimmed)
        self.dimmed = []


def tree_of(trick):
    return bases.tree_of(trick[:2])


def readers_of(scene):
    """(reader, closures) of each material of the scene's objects that can be changed."""
    for material in {slot.material for obj in scene.objects for slot in obj.material_slots if slot.material}:
        output = closures.output_of(material.node_tree) if closures.tree_of(material) else None
        if output is None or material.library:
            continue
        reader = closures.Reader(lambda reason: None, material.name)
        yield reader, reader.surface(output.inputs["Surface"], closures.top())


def tricks_of(scene):
    """(material or group, its name, node, output) of each such link in the scene's materials that cast caustics."""
    made = []
    for reader, found in readers_of(scene):
        if any(c.kind in ("glass", "refraction", "metal", "plastic") for c in found):
            made += [t for t in reader.tricks if t not in made]
    return made


def describe(scene):
    """What the add-on will switch, in words: [(sentence)]."""
    made = []
    on = [n for n in ("reflective", "refractive") if getattr(scene.cycles, "caustics_" + n)]
    if on:
        made.append(f"{' and '.join(on).capitalize()} caustics of Cycles are switched off for the render")
    casters = [o.name for o in scene.objects if getattr(o.cycles, "is_caustics_caster", False)] if hasattr(bpy.types.Object, "cycles") else []
    if casters and scene.cycles.caustics_refractive:
        made.append(f"Shadow caustics ({', '.join(casters[:3])}{'...' if len(casters) > 3 else ''}) make nothing meanwhile")
    for kind, name, _, output in tricks_of(scene):
        made.append(f'{kind.capitalize()} "{name}" lets light straight through by "{output}"; that is cut for the render')
    if bases.needed() and any(reader.plastics for reader, _ in readers_of(scene)):
        made.append("Bases of Principled are dimmed by their coats behind diffuse rays too, as with caustics on")
    return made
