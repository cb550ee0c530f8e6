# SPDX-License-Identifier: Apache-2.0
"""A small interpreter of Nuke scripts: reads the text, builds the nodes, evaluates pictures and expressions.

It knows what Foundry's manuals say of the nodes that it has, and refuses any other node or knob. A picture has its
rows from the bottom, a format and a box of pixels; outside of the box it is black."""
import os
import re
import struct

import numpy as np

import exrlib


class Node:
    def __init__(self, kind, knobs, users, inputs):
        self.kind, self.knobs, self.users, self.inputs = kind, knobs, users, inputs
        self.parent, self.inside, self.name = None, {}, knobs.get("name", kind)


def words(text):
    """A Tcl list: words, "quoted", {braced}."""
    out, at = [], 0
    while at < len(text):
        if text[at].isspace():
            at += 1
        elif text[at] == "{":
            depth, end = 1, at + 1
            while depth:
                if text[end] == "\\":
                    end += 1
                else:
                    depth += (text[end] == "{") - (text[end] == "}")
                end += 1
            out.append(text[at + 1:end - 1])
            at = end
        elif text[at] == '"':
            end, word = at + 1, ""
            while text[end] != '"':
                end += text[end] == "\\"
                word += text[end]
                end += 1
            out.append(word)
            at = end + 1
        else:
            end = at
            while end < len(text) and not text[end].isspace():
                end += 1
            out.append(text[at:end])
            at = end
    return out


def logical_lines(text):
    """Lines, joined while a brace is open."""
    held, depth = "", 0
    for line in text.splitlines():
        bare = re.sub(r'\\.|"(\\.|[^"\\])*"', "", line)
        depth += bare.count("{") - bare.count("}")
        held += line + "\n"
        if depth == 0:
            yield held.rstrip("\n")
            held = ""
    assert not held.strip(), "a brace is left open"


class Script:
    """nodes: {name: Node} of the root; layers: {layer: [channels]} that add_layer named."""

    def __init__(self, path):
        with open(path, encoding="utf-8") as file:
            text = file.read()
        self.folder, self.layers, self.nodes = os.path.dirname(os.path.abspath(path)), {}, {}
        stack, variables, groups = [], {}, []
        for line in logical_lines(text):
            line = line.strip()
            if not line or line.startswith(("#", "version ")):
                continue
            command, _, rest = line.partition(" ")
            if command == "add_layer":
                layer, *channels = words(words(rest)[0])
                self.layers[layer] = channels
            elif command == "set":
                match = re.fullmatch(r"(N\w+) \[stack 0\]", rest)
                variables[match[1]] = stack[-1]
            elif command == "push":
                stack.append(variables[rest[1:]])
            elif command == "end_group":
                inner = stack.pop()
                assert inner.kind == "Output", "a group ends in its Output"
                stack = groups.pop()
            else:
                self.add_node(command, rest, stack, groups)
                if command == "Group":
                    groups.append(stack)
                    stack = []
        assert not groups, "a group is left open"

    def add_node(self, kind, rest, stack, groups):
        knobs, users = {}, []
        for line in logical_lines(words(rest)[0]):
            name, _, value = line.strip().partition(" ")
            if name == "addUserKnob":
                users.append(words(words(value)[0]))
            elif name:
                assert name not in knobs, f"{kind}: {name} twice"
                knobs[name] = value.strip()
        count = int(knobs.pop("inputs", 1))
        node = Node(kind, knobs, users, [stack.pop() for _ in range(count)])
        parent = groups[-1][-1] if groups else None
        siblings = parent.inside if parent else self.nodes
        assert node.name not in siblings, f"two nodes are called {node.name}"
        node.parent = parent
        siblings[node.name] = node
        stack.append(node)


# ---- expressions


class Expression:
    """Numbers, knobs, + - * /, a ? b : c, pow, max, pi."""
    TOKEN = re.compile(r"\s*(?:(\d+\.?\d*(?:[eE][-+]?\d+)?|\.\d+)|([A-Za-z_][\w.]*)|(.))")

    def __init__(self, text, lookup):
        self.tokens = [m.groups() for m in self.TOKEN.finditer(text)] + [(None, None, None)]
        self.at, self.lookup = 0, lookup
        self.value = self.choice()
        assert self.tokens[self.at] == (None, None, None), f"after the expression: {text}"

    def take(self, mark):
        if self.tokens[self.at][2] == mark:
            self.at += 1
            return True
        return False

    def choice(self):
        condition = self.sum()
        if not self.take("?"):
            return condition
        yes = self.choice()
        assert self.take(":")
        no = self.choice()
        return yes if condition else no

    def sum(self):
        value = self.product()
        while True:
            if self.take("+"):
                value += self.product()
            elif self.take("-"):
                value -= self.product()
            else:
                return value

    def product(self):
        value = self.atom()
        while True:
            if self.take("*"):
                value *= self.atom()
            elif self.take("/"):
                value /= self.atom()
            else:
                return value

    def atom(self):
        if self.take("-"):
            return -self.atom()
        if self.take("("):
            value = self.choice()
            assert self.take(")")
            return value
        number, name, _ = self.tokens[self.at]
        self.at += 1
        if number:
            return float(number)
        if not self.take("("):
            return np.pi if name == "pi" else self.lookup(name)
        arguments = [self.choice()]
        while self.take(","):
            arguments.append(self.choice())
        assert self.take(")")
        return {"pow": lambda a, b: a ** b, "max": max}[name](*arguments)


def look_up(node, path):
    """What an expression in a node's knob calls NAME, NAME.r or parent.NAME."""
    pieces = path.split(".")
    if pieces[0] == "parent":
        node, pieces = node.parent, pieces[1:]
    return knob(node, pieces[0], pieces[1] if len(pieces) > 1 else None)


def knob(node, name, channel=None):
    """A knob's number: 1, true, {{expression}}, or one item of {1 2 {expression}}."""
    text = node.knobs[name]
    if not text.startswith("{"):
        return float({"true": 1, "false": 0}.get(text, text))
    items = words(words(text)[0])
    item = items["rgba".index(channel)] if channel and len(items) > 1 else items[0]
    return Expression(item, lambda path: look_up(node, path)).value


# ---- pictures


class Picture:
    def __init__(self, channels, box, size):
        self.channels, self.box, self.size = channels, box, size  # box: x, y, right, top, ends exclusive

    def get(self, name, box):
        """A channel over a box; black where it has no pixels, or is not there."""
        x, y, r, t = box
        out = np.zeros((t - y, r - x))
        if name in self.channels:
            a, b = (max(x, self.box[0]), max(y, self.box[1])), (min(r, self.box[2]), min(t, self.box[3]))
            if b[0] > a[0] and b[1] > a[1]:
                out[a[1] - y:b[1] - y, a[0] - x:b[0] - x] = self.channels[name][
                    a[1] - self.box[1]:b[1] - self.box[1], a[0] - self.box[0]:b[0] - self.box[0]]
        return out

    def changed(self, **more):
        return Picture({**self.channels, **more}, self.box, self.size)


COLOURS = {"R": "red", "G": "green", "B": "blue", "A": "alpha", "r": "red", "g": "green", "b": "blue", "a": "alpha"}


def nuke_channel(name):
    """As the Read node names an EXR channel: pieces between dots lose leading digits, what is no letter or digit is _."""
    pieces = [re.sub(r"[^A-Za-z0-9]", "_", re.sub(r"^[0-9]+", "", p)) for p in name.split(".")]
    layer = "_".join(pieces[:-1]) or "rgba"
    return f"{layer}.{COLOURS.get(pieces[-1], pieces[-1])}"


def read_exr(path):
    channels = {}
    for part in exrlib.read(path):
        x0, y0, x1, y1 = part.window
        dx0, dy0, dx1, dy1 = struct.unpack("<4i", part.attrs["displayWindow"][1])
        box = (x0 - dx0, dy1 - y1, x1 - dx0 + 1, dy1 - y0 + 1)
        size = (dx1 - dx0 + 1, dy1 - dy0 + 1)
        channels.update({nuke_channel(n): (np.asarray(v[::-1], float), box) for n, v in part.channels.items()})
    boxes = {b for _, b in channels.values()}
    assert len(boxes) == 1, "parts with different windows"
    return Picture({n: v for n, (v, _) in channels.items()}, boxes.pop(), size)


def channels_of(layer):
    if layer == "rgb":
        return ["rgba.red", "rgba.green", "rgba.blue"]
    return [f"{layer}.{c}" for c in ("red", "green", "blue", "alpha")]


class Evaluate:
    ALLOWED = {"Read": {"file_type", "file", "raw", "name", "first", "last", "origfirst", "origlast", "label"},
               "Shuffle": {"in", "out", "alpha", "name"}, "Multiply": {"channels", "value", "name"},
               "Merge2": {"operation", "bbox", "Achannels", "Bchannels", "output", "name"},
               "ColorMatrix": {"matrix", "name"}, "Transform": {"translate", "filter", "name"},
               "Input": {"number", "name"}, "Output": {"name"}}

    def __init__(self, script, frame=1):
        self.script, self.frame, self.made = script, frame, {}
        self.files = {}

    def __call__(self, node):
        if node not in self.made:
            if node.kind != "Group":
                extra = set(node.knobs) - self.ALLOWED[node.kind]
                assert not extra, f"{node.kind}: knobs {extra}"
            self.made[node] = getattr(self, node.kind)(node)
        return self.made[node]

    def Read(self, node):
        assert node.knobs["raw"] == "true", "the numbers as they are"
        path = words(node.knobs["file"])[0].replace("[file dirname [value root.name]]", self.script.folder)
        path = re.sub(r"\\(.)", r"\1", path)
        path = re.sub("#+", lambda m: f"{self.frame:0{len(m[0])}d}", path)
        self.files[node.name] = path
        return read_exr(path)

    def Group(self, node):
        output, = [n for n in node.inside.values() if n.kind == "Output"]
        return self(output)

    def Input(self, node):
        return self(node.parent.inputs[int(node.knobs.get("number", 0))])

    def Output(self, node):
        return self(node.inputs[0])

    def Shuffle(self, node):
        picture = self(node.inputs[0])
        out = {}
        for to, source in zip(channels_of(node.knobs.get("out", "rgba")), channels_of(node.knobs.get("in", "rgba"))):
            black = to.endswith(".alpha") and node.knobs.get("alpha") == "black"
            if black or source in picture.channels or to in picture.channels:
                out[to] = np.zeros_like(picture.get(to, picture.box)) if black else picture.get(source, picture.box)
        source_layer = node.knobs.get("in", "rgba")
        assert any(c.startswith(source_layer + ".") for c in picture.channels), f"no layer {source_layer}"
        return picture.changed(**out)

    def Multiply(self, node):
        picture = self(node.inputs[0])
        assert node.knobs["channels"] == "rgb"
        return picture.changed(**{c: picture.get(c, picture.box) * knob(node, "value", "rgb"[i])
                                  for i, c in enumerate(channels_of("rgb"))})

    def ColorMatrix(self, node):
        picture = self(node.inputs[0])
        matrix = [[Expression(cell, lambda path: look_up(node, path)).value for cell in words(row)]
                  for row in words(words(node.knobs["matrix"])[0])]
        old = [picture.get(c, picture.box) for c in channels_of("rgb")]
        return picture.changed(**{c: sum(m * o for m, o in zip(row, old)) for c, row in zip(channels_of("rgb"), matrix)})

    def Merge2(self, node):
        b, a = (self(n) for n in node.inputs)
        assert [node.knobs[k] for k in ("Achannels", "Bchannels", "output", "bbox")] == ["rgb", "rgb", "rgb", "B"]
        operate = {"plus": np.add, "multiply": np.multiply}[node.knobs["operation"]]
        return b.changed(**{c: operate(a.get(c, b.box), b.get(c, b.box)) for c in channels_of("rgb")})

    def Transform(self, node):
        picture = self(node.inputs[0])
        assert node.knobs["filter"] == "Impulse"
        x, y = (int(v) for v in words(words(node.knobs["translate"])[0]))
        box = picture.box
        return Picture(picture.channels, (box[0] + x, box[1] + y, box[2] + x, box[3] + y), picture.size)
