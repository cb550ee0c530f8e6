# SPDX-License-Identifier: Apache-2.0
# ---- What follows is the same in every script; the shot is above. Blender 3.4, 4.x and 5.x. ----
import json
import os
import sys

import bpy

MARK = "caustics_relight"  # property of everything that this script makes
GROUP = "Caustics Relight"
HAS_TREES = "compositing_node_group" in bpy.types.Scene.bl_rna.properties  # 5.0 on
SLIDERS = (("EV", "ev", "NodeSocketFloat", -12, 12), ("gain", "gain", "NodeSocketFloat", None, None),
           ("tint", "tint", "NodeSocketColor", None, None), ("mute", "mute", "NodeSocketFloatFactor", 0, 1),
           ("solo", "solo", "NodeSocketFloatFactor", 0, 1), ("saturation", "saturation", "NodeSocketFloat", 0, 100))


class Graph:
    """A compositor tree, and nodes in it by what they do. An operand is a socket or a number."""

    def __init__(self, tree):
        self.tree, self.count = tree, 0

    def new(self, *kinds):
        for kind in kinds:  # the first that this Blender has
            try:
                node = self.tree.nodes.new(kind)
            except RuntimeError:
                continue
            node.location = (200 * (self.count // 12), -180 * (self.count % 12))
            node[MARK], node.hide, self.count = 1, True, self.count + 1
            return node
        raise RuntimeError("this Blender has none of the nodes " + ", ".join(kinds))

    def connect(self, operand, socket):
        if isinstance(operand, bpy.types.NodeSocket):
            self.tree.links.new(operand, socket)
        else:
            socket.default_value = operand

    def math(self, operation, a, b):
        node = self.new("CompositorNodeMath", "ShaderNodeMath")
        node.operation = operation
        self.connect(a, node.inputs[0])
        self.connect(b, node.inputs[1])
        return node.outputs[0]

    def mix(self, operation, a, b):
        """Of two pictures, or a picture and a number; alpha is that of a."""
        node = self.new("CompositorNodeMixRGB", "ShaderNodeMix")
        node.blend_type = operation
        if node.bl_idname == "ShaderNodeMix":
            node.data_type = "RGBA"
            sockets = {s.identifier: s for s in [*node.inputs, *node.outputs]}
            factor, one, two, out = (sockets[n] for n in ("Factor_Float", "A_Color", "B_Color", "Result_Color"))
        else:
            (factor, one, two), out = node.inputs[:3], node.outputs[0]
        factor.default_value = 1
        self.connect(a, one)
        self.connect(b, two)
        return out

    def convert(self, picture, matrix):
        """A 3 x 3 matrix, row by row; none is the identity."""
        if not matrix:
            return picture
        split, join = self.new("CompositorNodeSeparateColor"), self.new("CompositorNodeCombineColor")
        split.mode = join.mode = "RGB"
        self.connect(picture, split.inputs[0])
        for row in range(3):
            terms = [self.math("MULTIPLY", split.outputs[c], matrix[3 * row + c]) for c in range(3)]
            self.connect(self.math("ADD", self.math("ADD", terms[0], terms[1]), terms[2]), join.inputs[row])
        return join.outputs[0]


    def saturate(self, picture, weights, amount):
        """amount x picture + (1 - amount) x its luminance."""
        split = self.new("CompositorNodeSeparateColor")
        split.mode = "RGB"
        self.connect(picture, split.inputs[0])
        terms = [self.math("MULTIPLY", split.outputs[c], weights[c]) for c in range(3)]
        luminance = self.math("ADD", self.math("ADD", terms[0], terms[1]), terms[2])
        grey = self.math("MULTIPLY", luminance, self.math("SUBTRACT", 1.0, amount))
        return self.mix("ADD", self.mix("MULTIPLY", picture, amount), grey)


def load(path, raw):
    """The picture at `path`; raw: its numbers as they are."""
    image = bpy.data.images.load(path, check_existing=True)
    if raw:
        image.colorspace_settings.name = "Non-Color"
    if SHOT["frames"]:
        image.source = "SEQUENCE"
    return image


class Source:
    """One file in a tree: a node for each of the layers that Blender sees in it."""

    def __init__(self, graph, image):
        self.graph, self.image, self.nodes = graph, image, {}

    def node(self, layer):
        """A node that shows this layer, or the first for ""; None when there is no such layer."""
        if layer not in self.nodes:
            node = self.graph.new("CompositorNodeImage")
            node.image, node.label = self.image, os.path.basename(self.image.filepath)
            self.image.size[:]  # reads the file, and so finds the layers
            if SHOT["frames"]:
                first, last = SHOT["frames"]
                node.frame_start, node.frame_duration, node.frame_offset = first, last - first + 1, first - 1
            try:
                if layer:
                    node.layer = layer
            except TypeError:
                self.graph.tree.nodes.remove(node)
                node = None
            self.nodes[layer] = node
        return self.nodes[layer]

    def socket(self, name):
        """Blender 4.x takes each part of a file of several parts for a layer; 3.x and 5.x take it for a pass."""
        layer, _, bare = name.rpartition(".")
        for place, wanted in ((layer, bare), (bare, bare)) if name else (("", "Combined"), ("", "Image")):
            node = self.node(place)
            if node and wanted in node.outputs:
                return node.outputs[wanted]
        raise RuntimeError(f"{self.image.filepath}: Blender finds no layer \"{name}\" in it; it has "
                           + ", ".join(s.name for s in self.node("").outputs))


def add_socket(tree, direction, kind, name, value=None, low=None, high=None, panel=None):
    if hasattr(tree, "interface"):
        base = "NodeSocketFloat" if kind == "NodeSocketFloatFactor" else kind
        more = {"parent": panel} if panel else {}
        socket = tree.interface.new_socket(name, in_out=direction, socket_type=base, **more)
        if base != kind:
            socket.subtype = "FACTOR"
    else:
        socket = (tree.inputs if direction == "INPUT" else tree.outputs).new(kind, name)
    if value is not None:
        socket.default_value = value
    if low is not None:
        socket.min_value, socket.max_value = low, high


def sliders(light):
    """Those of a light: saturation only where the picture had one."""
    return [slider for slider in SLIDERS if slider[1] != "saturation" or light["saturation"] is not None]


def value_of(light, key):
    return [*light[key], 1] if key == "tint" else float(light[key])


def make_sockets(tree):
    add_socket(tree, "OUTPUT", "NodeSocketColor", "Image")
    add_socket(tree, "INPUT", "NodeSocketColor", "Image", [0, 0, 0, 1])
    if SHOT["albedo"]:
        add_socket(tree, "INPUT", "NodeSocketColor", "Albedo", [1, 1, 1, 1])
    for light in SHOT["lights"]:
        panel = tree.interface.new_panel(light["label"]) if hasattr(tree, "interface") else None
        for shown, key, kind, low, high in sliders(light):
            add_socket(tree, "INPUT", kind, f"{light['label']} {shown}", value_of({**light, **PLAIN}, key), low, high, panel)


PLAIN = {"ev": 0, "gain": 1, "tint": [1, 1, 1], "mute": 0, "solo": 0, "saturation": 1}


def factors(graph, inputs):
    """For every light its number and its tint, as sockets."""
    def on(light, name):
        return graph.math("GREATER_THAN", inputs[f"{light['label']} {name}"], 0.5)

    lights = {light["key"]: light for light in SHOT["lights"]}
    solo = {key: on(light, "solo") for key, light in lights.items()}
    any_solo = 0.0
    for socket in solo.values():
        any_solo = graph.math("MAXIMUM", any_solo, socket)
    no_solo = graph.math("SUBTRACT", 1.0, any_solo)
    made = {}
    for key, light in lights.items():
        strength = graph.math("POWER", 2.0, inputs[f"{light['label']} EV"])
        strength = graph.math("MULTIPLY", strength, inputs[f"{light['label']} gain"])
        strength = graph.math("MULTIPLY", strength, graph.math("SUBTRACT", 1.0, on(light, "mute")))
        tints, own_solo = [inputs[f"{light['label']} tint"]], solo[key]
        if light["of"]:  # its light's settings count as well
            parent, parent_tints = made[light["of"]]
            strength, tints = graph.math("MULTIPLY", strength, parent), tints + parent_tints
            own_solo = graph.math("MAXIMUM", own_solo, solo[light["of"]])
        made[key] = strength, tints
        gate = graph.math("MAXIMUM", own_solo, no_solo)
        light["factor"] = graph.math("MULTIPLY", strength, gate), tints
    return lights


def add_layers(graph, source, inputs, lights, weighted):
    """The sum of the layers that are weighted by the albedo, or of those that are not; None when there are none."""
    total = None
    for layer in SHOT["layers"]:
        if layer["albedo"] != weighted:
            continue
        light = lights[layer["light"]]
        strength, tints = light["factor"]
        picture = graph.convert(source.socket(layer["layer"]), SHOT["to_tint"])
        for of in (light, lights.get(light["of"])):
            if of and of["saturation"] is not None:
                picture = graph.saturate(picture, SHOT["luminance"], inputs[f"{of['label']} saturation"])
        picture = graph.mix("MULTIPLY", picture, strength)
        for tint in tints:
            picture = graph.mix("MULTIPLY", picture, tint)
        total = picture if total is None else graph.mix("ADD", total, picture)
    return None if total is None else graph.convert(total, SHOT["to_beauty"])


def make_group(raw):
    tree = bpy.data.node_groups.new(GROUP, "CompositorNodeTree")
    tree[MARK] = json.dumps({"lights": [light["label"] for light in SHOT["lights"]], "tint_space": SHOT["tint_space"]})
    make_sockets(tree)
    graph = Graph(tree)
    inputs, output = graph.new("NodeGroupInput").outputs, graph.new("NodeGroupOutput")
    source = Source(graph, load(find(SHOT["caustics"]), raw))
    lights = factors(graph, inputs)
    result = inputs["Image"]
    weighted, plain = (add_layers(graph, source, inputs, lights, w) for w in (True, False))
    if weighted is not None:
        weighted = graph.mix("MULTIPLY", weighted, graph.math("DIVIDE", 1.0, 3.14159265358979323846))
        result = graph.mix("ADD", result, graph.mix("MULTIPLY", weighted, inputs["Albedo"]))
    if plain is not None:
        result = graph.mix("ADD", result, plain)
    graph.connect(result, output.inputs["Image"])
    return tree


def scene_tree(scene):
    if HAS_TREES:
        if scene.compositing_node_group is None:
            scene.compositing_node_group = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
        return scene.compositing_node_group
    scene.use_nodes = True
    return scene.node_tree


def remove_earlier(tree):
    """What an earlier run made; who took its picture takes the beauty again."""
    for node in [n for n in tree.nodes if n.get(MARK)]:
        if node.bl_idname == "CompositorNodeGroup" and node.inputs["Image"].is_linked:
            source = node.inputs["Image"].links[0].from_socket
            for link in list(node.outputs[0].links):
                tree.links.new(source, link.to_socket)
    for node in [n for n in tree.nodes if n.get(MARK) and n.bl_idname != "CompositorNodeRLayers"]:
        old = node.node_tree if node.bl_idname == "CompositorNodeGroup" else None
        tree.nodes.remove(node)
        if old and not old.users:
            bpy.data.node_groups.remove(old)


def output_socket(graph):
    """The picture's end of the line: a Composite node, since 5.0 the tree's own output."""
    tree = graph.tree
    kind = "NodeGroupOutput" if HAS_TREES else "CompositorNodeComposite"
    ends = [n for n in tree.nodes if n.bl_idname == kind]
    if kind == "NodeGroupOutput" and not any(i.item_type == "SOCKET" and i.in_out == "OUTPUT" for i in tree.interface.items_tree):
        add_socket(tree, "OUTPUT", "NodeSocketColor", "Image")
    end = ends[0] if ends else graph.new(kind)
    return end.inputs[0]


def render_layers(graph):
    """The sockets of the beauty and, where it is wanted, of its Diffuse Color pass, from this scene's own render."""
    found = [n for n in graph.tree.nodes if n.bl_idname == "CompositorNodeRLayers"]
    node = found[0] if found else graph.new("CompositorNodeRLayers")
    albedo = None
    if SHOT["albedo"]:
        bpy.context.scene.view_layers[node.layer].use_pass_diffuse_color = True
        albedo = next(node.outputs[n] for n in ("Diffuse Color", "DiffCol") if n in node.outputs)
    return node.outputs["Image"], albedo


def find(path):
    """Paths are relative to this script."""
    here = os.path.dirname(os.path.abspath(bpy.path.abspath(__file__))) if "__file__" in globals() else ""
    return os.path.normpath(os.path.join(here, path))


def place(source, group, end):
    """From left to right, with room for the sliders."""
    if source.get(MARK):
        source.location = (end.location.x - 700, end.location.y)
    group.location = (source.location.x + 380, source.location.y)
    if end.location.x < group.location.x + 340:
        end.location.x = group.location.x + 340


def build(beauty=None):
    scene = bpy.context.scene
    tree = scene_tree(scene)
    remove_earlier(tree)
    graph = Graph(tree)
    beauty = beauty or (SHOT["beauty"] and find(SHOT["beauty"]))
    if beauty:
        source = Source(graph, load(beauty, raw=True))
        picture, albedo = source.socket(SHOT["pass"]), SHOT["albedo"] and source.socket(SHOT["albedo"])
        scene.render.resolution_x, scene.render.resolution_y = SHOT["size"]
        scene.render.resolution_percentage = 100
    else:
        picture, albedo = render_layers(graph)
    takers = [link.to_socket for link in picture.links]
    node = graph.new("CompositorNodeGroup")
    node.node_tree, node.name, node.hide, node.width = make_group(raw=bool(beauty)), GROUP, False, 260
    graph.connect(picture, node.inputs["Image"])
    if albedo:
        graph.connect(albedo, node.inputs["Albedo"])
    for light in SHOT["lights"]:
        for shown, key, *_ in sliders(light):
            node.inputs[f"{light['label']} {shown}"].default_value = value_of(light, key)
    end = output_socket(graph)
    place(picture.node, node, end.node)
    for socket in takers or [end]:
        graph.connect(node.outputs[0], socket)
    return node


if __name__ == "__main__":
    words = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    build(os.path.abspath(words[0]) if words else None)
    print(f"{GROUP}: {len(SHOT['lights'])} lights; the sliders are on the group node of that name")
