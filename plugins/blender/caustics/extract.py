# SPDX-License-Identifier: Apache-2.0
"""A scene as Cycles sees it, from an evaluated dependency graph, written to a folder as a scene file with its meshes."""
import json
import os

from mathutils import Matrix

from . import lamps, meshes, views
from .errors import CausticsError, Notes
from .materials import Materials

SOLID = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
UNBUILT = {"VOLUME": "volumes", "CURVES": "hair curves", "POINTCLOUD": "point clouds", "HAIR": "hair", "GPENCIL": "grease pencil",
           "GREASEPENCIL": "grease pencil"}
FILE_NAME = "scene.json"
RAYS = (("diffuse", "visible_diffuse"), ("glossy", "visible_glossy"), ("transmission", "visible_transmission"), ("shadow", "visible_shadow"))


class Extract:
    """What was found. doc: the scene file. region: of the render border or None. notes: a Notes. textured: names of the
    materials that want the Diffuse Color pass. triangles: how many, instances counted. path: of the scene file."""

    def __init__(self, folder, pointers=True, baker=None):
        self.folder, self.pointers = folder, pointers
        self.notes, self.triangles, self.files = Notes(), 0, 0
        self.materials = Materials(self.notes, baker and baker.means)
        for note in baker.notes if baker else ():
            self.notes.add(*note)
        self.names, self.parts, self.objects, self.lights = set(), {}, [], []
        self.strengths = {}  # {layer's name: {name of a lamp's data: (energy, exposure)}}
        self.doc, self.region, self.layer, self.view_layer, self.frame = None, None, None, "", 0
        self.path = os.path.join(folder, FILE_NAME)

    @property
    def textured(self):
        return self.materials.textured

    def read(self, depsgraph):
        """Reads all and writes the files."""
        scene = depsgraph.scene_eval
        self.layer, self.frame = depsgraph.view_layer, scene.frame_current
        self.view_layer = self.layer.name
        for other in depsgraph.scene.view_layers:
            if other.use and other.name != self.view_layer:
                self.notes.add(f'View layer "{other.name}"', f'caustics are those of "{self.view_layer}"; its own picture stays as it is')
        camera = views.camera(scene.camera and scene.camera.evaluated_get(depsgraph), scene, self.notes)
        self.region = views.region(scene.render)
        for instance in depsgraph.object_instances:
            self.instance(instance)
        self.doc = {"caustics_scene": 1, "color_space": views.color_space(scene), "camera": camera, "bounces": views.bounces(scene.cycles),
                    "materials": {}, "objects": self.objects, "lights": self.lights}
        world = lamps.world(scene.world and scene.world.evaluated_get(depsgraph), lambda r: self.notes.add("World", r))
        if world:
            self.doc["world"] = world
        self.doc["materials"] = {name: self.materials.items[name] for name in sorted({o["material"] for o in self.objects})}
        with open(self.path, "w", encoding="utf-8") as f:
            json.dump(self.doc, f, indent=1, allow_nan=False)
        return self

    def unique(self, name):
        made, n = name, 1
        while made in self.names:
            n += 1
            made = f"{name} #{n}"
        self.names.add(made)
        return made

    def instance(self, instance):
        obj = instance.object
        if not instance.show_self:
            return
        if obj.type == "LIGHT":
            name = self.unique(obj.name)
            made = lamps.lamp(obj, instance.matrix_world, name, lambda r: self.notes.add(f'Light "{obj.name}"', r))
            if made:
                if not takes_part(obj, "casts"):
                    made["casts_caustics"] = False
                self.lights.append(made)
                strength = float(obj.data.energy), float(getattr(obj.data, "exposure", 0.0))
                self.strengths.setdefault(made["group"], {})[obj.data.original.name_full] = strength
        elif obj.type in SOLID:
            self.solid(obj, instance)
        elif obj.type in UNBUILT:
            self.notes.add(f'Object "{obj.name}"', f"{UNBUILT[obj.type]} are not built; it is left out")
        if obj.particle_systems and any(p.settings.type == "HAIR" and p.settings.render_type == "PATH" for p in obj.particle_systems):
            self.notes.add(f'Object "{obj.name}"', "hair is not built; it is left out")

    # ---- meshes ------------------------------------------------------------------------------------------------------

    def solid(self, obj, instance):
        slots = [slot.material for slot in obj.material_slots]
        key = (obj.type, obj.data.as_pointer() if obj.data else obj.original.name_full, tuple(m.name_full if m else "" for m in slots))
        if key not in self.parts or obj.type != "MESH" and not instance.is_instance:
            self.parts[key] = self.write_parts(obj, slots)
        parts, matrix = self.parts[key], instance.matrix_world
        if parts and singular(matrix):
            parts, matrix = self.flattened(obj, parts, matrix), Matrix()
        for material, smooth, file, count in parts:
            self.triangles += count
            name = self.unique(obj.name if len(parts) == 1 else f"{obj.name} ({material}{'' if smooth else ', flat'})")
            self.objects.append({"name": name, "file": file, "material": material, "smooth": smooth,
                                 **self.placed(obj, matrix), **self.visibility(obj, instance)})

    def placed(self, obj, matrix):
        rows = lamps.rows(matrix)
        if not all(abs(x) < 1e30 for row in rows for x in row):  # NaN is not less either
            raise CausticsError(f'Object "{obj.name}" is placed at a number that is not finite; check its transform and constraints.')
        return {"matrix": rows}

    def flattened(self, obj, parts, matrix):
        """Scaled to a sheet: its faces where they end up, which no matrix of the scene format can say."""
        self.notes.add(f'Object "{obj.name}"', "its scale is 0 along an axis; it is taken as flat faces, without those of no area")
        made = []
        for material, _, file, _ in parts:
            name = self.next_file()
            count = meshes.flatten(os.path.join(self.folder, file), os.path.join(self.folder, name), lamps.rows(matrix))
            if count:
                made.append((material, False, name, count))
        return made

    def visibility(self, obj, instance):
        who = [obj] + ([instance.parent] if instance.is_instance and instance.parent else [])
        made = {}
        if not all(o.visible_camera for o in who) or self.by_layer(who, "indirect_only_get"):
            made["visible_to_camera"] = False
        rays = [ray for ray, flag in RAYS if all(getattr(o, flag) for o in who)]
        if len(rays) < len(RAYS):
            made["visible_to"] = rays
        for key, flag in (("casts_caustics", "casts"), ("receives_caustics", "receives")):
            if not all(takes_part(o, flag) for o in who):
                made[key] = False
        if any(o.is_holdout for o in who) or self.by_layer(who, "holdout_get"):
            made["receives_caustics"] = False
            self.notes.add(f'Object "{obj.name}"', "a holdout shows no caustics, in mirrors and through glass either")
        if any(o.is_shadow_catcher for o in who):
            self.notes.add(f'Object "{obj.name}"', "caustics on a shadow catcher are added as light over its transparent pixels")
        return made

    def by_layer(self, who, what):
        """What collections say of objects in this view layer."""
        return any(getattr(o.original, what)(view_layer=self.layer) for o in who)

    def write_parts(self, obj, slots):
        """The PLY files of an object's mesh, one per material and shading: [(material, smooth, file, triangles)]."""
        np = meshes.numpy()
        mesh = obj.to_mesh()
        try:
            found = meshes.read(mesh, self.pointers) if mesh else None
            if mesh and not slots:
                slots = list(mesh.materials)
        finally:
            obj.to_mesh_clear()
        if not found:
            return []
        if not np.isfinite(found.co).all():
            at = int(np.nonzero(~np.isfinite(found.co).all(axis=1))[0][0])
            raise CausticsError(f'Object "{obj.name}" has a vertex ({at}) at a number that is not finite; merge or delete it.')
        index = np.clip(found.material, 0, max(len(slots) - 1, 0))
        made = []
        for material in np.unique(index):
            name = self.materials.name_of(slots[material] if slots else None)
            for smooth in (True, False):
                mask = (index == material) & (found.smooth == smooth)
                if mask.any():
                    made.append((name, smooth, self.write(found, mask, smooth), int(mask.sum())))
        return made

    def next_file(self):
        os.makedirs(os.path.join(self.folder, "meshes"), exist_ok=True)
        self.files += 1
        return f"meshes/{self.files:05d}.ply"

    def write(self, found, mask, smooth):
        file = self.next_file()
        meshes.write_ply(os.path.join(self.folder, file), *meshes.part(found, mask, smooth))
        return file


def singular(matrix):
    sides = lamps.scales(matrix)
    return abs(matrix.to_3x3().determinant()) <= 1e-9 * max(max(sides) ** 3, 1e-30)


def takes_part(obj, flag):
    settings = getattr(obj.original, "caustics", None)
    return getattr(settings, flag, True)
