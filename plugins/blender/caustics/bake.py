# SPDX-License-Identifier: Apache-2.0
"""Means of what varies over casters, baked by Cycles.

The renderer has no textures on what casts caustics. So where a socket of a caster's material cannot be followed to a number,
Cycles bakes it to the vertices of the evaluated mesh, and its mean by area stands in. Sockets inside node groups are not
baked. Everything is made in a scene of its own, which goes again."""
import bpy

from . import closures, meshes

SOLID = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
CASTING = {"glass", "refraction", "metal", "plastic"}
FACES, LEVELS = 20000, 6  # coarse meshes are subdivided to so many, at most so often
OBJECTS = 8               # of those that share a material, so many are looked at
ATTRIBUTE = "caustics_bake"


class Baker:
    """means: {(material, node, identifier of its input): (r, g, b)}. notes: [(material, reason)] of what failed."""

    def __init__(self, scene):
        self.scene = scene.name
        self.means, self.notes = {}, []

    def steps(self):
        """Yields after each bake, of a second or less."""
        window = window_of()
        if window is None:
            return
        for material, (inputs, objects) in self.wanted().items():
            for node, identifier in inputs:
                try:
                    mean = self.mean(window, material, node, identifier, objects)
                except RuntimeError as error:
                    reason = str(error).replace("Error: ", "").strip().splitlines()[-1]
                    self.notes.append((f'Material "{material}"', f"Cycles could not bake it ({reason})"))
                    break
                if mean is not None:
                    self.means[material, node, identifier] = mean
                yield

    def run(self):
        for _ in self.steps():
            pass
        return self

    def wanted(self):
        """{material: (inputs as (node, identifier), names of the objects that have it)} of casters."""
        made = {}
        for obj in bpy.data.scenes[self.scene].objects:
            if obj.type not in SOLID or obj.hide_render:
                continue
            for material in {slot.material for slot in obj.material_slots if slot.material}:
                if material.name_full not in made:
                    made[material.name_full] = (varying(material), [])
                made[material.name_full][1].append(obj.name)
        return {name: (inputs, objects[:OBJECTS]) for name, (inputs, objects) in made.items() if inputs}

    def mean(self, window, material, node, identifier, objects):
        """By area over all of these objects; None where they have none."""
        total, area = 0.0, 0.0
        for name in objects:
            place = Place(window, bpy.data.scenes[self.scene])
            try:
                part, weight = place.bake(bpy.data.scenes[self.scene].objects[name], material, node, identifier)
            finally:
                place.remove()
            total, area = total + part, area + weight
        return tuple(float(x) for x in total / area) if area > 0 else None


def window_of():
    windows = bpy.context.window_manager.windows if bpy.context.window_manager else ()
    return windows[0] if len(windows) else None


def varying(material):
    """Inputs of a caster's shaders that are no constants, as (node, identifier)."""
    output = closures.output_of(material.node_tree) if closures.tree_of(material) else None
    if output is None:
        return []
    reader = closures.Reader(lambda reason: None, material.name_full)
    found = reader.surface(output.inputs["Surface"], closures.top())
    return list(dict.fromkeys(reader.varying)) if any(c.kind in CASTING for c in found) else []


class Place:
    """A scene for one bake."""

    def __init__(self, window, scene):
        self.window, self.shown = window, window.scene
        self.made = []  # (collection of bpy.data, what is in it)
        self.scene = self.own("scenes", bpy.data.scenes.new("caustics bake"))
        self.scene.render.engine = "CYCLES"
        self.scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        c = self.scene.cycles
        c.device, c.samples, c.use_adaptive_sampling, c.use_denoising = "CPU", 1, False, False

    def own(self, kind, data):
        self.made.append((getattr(bpy.data, kind), data))
        return data

    def remove(self):
        self.window.scene = self.shown
        for where, data in reversed(self.made):
            where.remove(data)
        self.made = []

    def bake(self, obj, material, node, identifier):
        """(sum of the input's values by area, area)."""
        np = meshes.numpy()
        slots = [slot.material.name_full if slot.material else "" for slot in obj.material_slots]
        emitter = self.emitter(next(s.material for s in obj.material_slots if s.material and s.material.name_full == material), node, identifier)
        body = self.body(obj, emitter)
        mesh = body.data
        if not len(mesh.polygons):
            return np.zeros(3), 0.0
        self.window.scene = self.scene
        layer = self.scene.view_layers[0]
        layer.objects.active = body
        body.select_set(True, view_layer=layer)
        layer.update()
        bpy.ops.object.bake(type="EMIT", target="VERTEX_COLORS", use_clear=False, use_selected_to_active=False)
        color = meshes.by_foreach(mesh.color_attributes[ATTRIBUTE].data, "color", "f4", 4)[:, :3]
        mine = np.array([name == material for name in slots] or [True])
        return weighted(mesh, np.nan_to_num(color, posinf=0, neginf=0), mine)

    def emitter(self, material, node, identifier):
        """A copy of the material that shines with what feeds the input."""
        copy = self.own("materials", material.copy())
        tree = copy.node_tree
        to = next(s for s in tree.nodes[node].inputs if s.identifier == identifier)
        shine = tree.nodes.new("ShaderNodeEmission")
        tree.links.new(to.links[0].from_socket, shine.inputs["Color"])
        output = closures.output_of(tree)
        tree.links.new(shine.outputs[0], output.inputs["Surface"])
        for link in list(output.inputs["Displacement"].links):
            tree.links.remove(link)
        return copy

    def body(self, obj, emitter):
        """Its evaluated mesh, fine enough, with the emitter all over."""
        source = self.own("objects", obj.copy())
        self.scene.collection.objects.link(source)
        source.hide_viewport = False
        layer = self.scene.view_layers[0]
        if obj.type == "MESH":
            levels = levels_of(len(obj.data.polygons))
            if levels:
                fine = source.modifiers.new("caustics bake", "SUBSURF")
                fine.subdivision_type, fine.levels = "SIMPLE", levels
        layer.update()
        mesh = self.own("meshes", bpy.data.meshes.new_from_object(source.evaluated_get(layer.depsgraph), preserve_all_data_layers=True,
                                                                  depsgraph=layer.depsgraph))
        self.scene.collection.objects.unlink(source)
        body = self.own("objects", bpy.data.objects.new("caustics bake", mesh))
        body.matrix_world, body.color, body.pass_index = obj.matrix_world, obj.color, obj.pass_index
        self.scene.collection.objects.link(body)
        if not len(mesh.materials):
            mesh.materials.append(emitter)
        for i in range(len(mesh.materials)):
            mesh.materials[i] = emitter
        mesh.attributes.new(ATTRIBUTE, "FLOAT_COLOR", "POINT")
        mesh.color_attributes.active_color = mesh.color_attributes[ATTRIBUTE]
        return body


def levels_of(faces):
    levels = 0
    while faces and faces * 4**levels < FACES and levels < LEVELS:
        levels += 1
    return levels


def weighted(mesh, color, mine):
    """(sum over the faces of slots in `mine` of their mean color times area, their area)."""
    np = meshes.numpy()
    count = len(mesh.polygons)
    total, vertex = meshes.by_foreach(mesh.polygons, "loop_total", "i4", 1).ravel(), meshes.by_foreach(mesh.loops, "vertex_index", "i4", 1).ravel()
    area, slot = meshes.by_foreach(mesh.polygons, "area", "f4", 1).ravel().astype("f8"), meshes.by_foreach(mesh.polygons, "material_index", "i4", 1).ravel()
    area = np.where(mine[np.clip(slot, 0, len(mine) - 1)], area, 0.0)
    of = np.repeat(np.arange(count), total)
    share = (area / np.maximum(total, 1))[of]
    return (color[vertex] * share[:, None]).sum(axis=0), area.sum()
