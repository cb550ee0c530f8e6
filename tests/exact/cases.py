# SPDX-License-Identifier: Apache-2.0
"""Scenes whose caustics are known. Each case renders with estimators W, P and R and returns rows for one table.

A row: (case, quantity, truth, {estimator: Figure}, {estimator: bias}). P's kernel has a width, so where a picture is
not smooth a bias is allowed to it, stated in the table and smaller with more photons; W's triangles are flat and evenly lit, which costs 1 % at
effort 1 and falls with the rays; R has none."""
import math

import numpy as np

import truth
from rig import (ball, box, down_camera, look_camera, over_seeds, plane, run, scene, sun)

SEEDS = range(1, 9)

# Samples per run at effort 1: photons of P; camera paths of R. R traces as many light paths as pixels per pass.
PHOTONS, PATHS = 60000, 160000

# Surfaces that a path may meet; what that cuts off counts in a closed room of mirrors alone.
DEPTH_MAX = 1000


class Effort:
    def __init__(self, factor=1.0, seeds=SEEDS):
        self.factor, self.seeds = factor, seeds

    def blur(self, bias):
        """Bias of P at effort 1 to that of this effort: the kernel's width goes with N^(-1/6)."""
        return {"P": bias * self.factor**(-1 / 6)}

    def coarse(self, exact):
        """Bias of W: its triangles are flat and evenly lit; second order in the cells' size."""
        return 0.01 * abs(exact) / self.factor

    def words(self, estimator, seed, share=1.0):
        n = int((PATHS if estimator == "R" else PHOTONS) * self.factor * share)
        return ["--estimator", estimator, "--photons", n, "--seed", seed]


def direct(s, effort, estimator, seed, share=1.0, albedo=1.0):
    """Irradiance of the direct caustics on a receiver, green channel, with the run."""
    result = run(s, *effort.words(estimator, seed, share), "--effects", "direct", "--layers", "radiance")
    return math.pi / albedo * result["caustics_Sun"][:, :, 1], result


def both(measure, effort, estimators="WPR"):
    """{quantity: {estimator: Figure}} of measure(estimator, seed) -> {quantity: number}."""
    out = {}
    for estimator in estimators:
        for key, figure in over_seeds(effort.seeds, lambda seed: measure(estimator, seed)).items():
            out.setdefault(key, {})[estimator] = figure
    return out


# ---- ball lens ----

def ball_box():
    """A unit ball in an open box of walls 8 m wide. Light comes through a disk of ior 1 that is just as wide as the
    ball: it is then the scattering next to the light, to which no limit applies, and a glossy limit of 0 cuts every
    reflection at the ball, outside and inside."""
    disk = {"name": "Disk", "shape": {"type": "lathe", "profile": [[0, 0], [1, 0]], "segments": 2048},
            "position": [0, 0, 2.5], "material": "air"}
    walls = [plane("Floor", [8, 8], [0, 0, -1.5])]
    for i, (x, y, turn) in enumerate(((4, 0, (0, -90, 0)), (-4, 0, (0, 90, 0)), (0, 4, (90, 0, 0)), (0, -4, (-90, 0, 0)))):
        size = [3, 8] if x else [8, 3]
        walls.append(plane(f"Wall{i}", size, [x, y, 0], rotation=turn))
    return [disk, ball("Ball", 1, [0, 0, 0])] + walls


def ball_transmitted(effort):
    """Floor and one wall, times four by symmetry, hold all that the ball lets straight through."""
    limits = {"total": 16, "diffuse": 4, "glossy": 0, "transmission": 16}
    objects = ball_box()
    floor = scene(down_camera(0, 0, -1.2, 8, [32, 32]), objects, [sun([0, 0, -1])], limits)
    wall = scene(look_camera([2, 0, 0], [3, 0, 0], 8, [32, 12]), objects, [sun([0, 0, -1])], limits)

    def measure(estimator, seed):
        below, result = direct(floor, effort, estimator, seed)
        beside, _ = direct(wall, effort, estimator, seed + 100)
        out = {"pixels": (below.mean() * 64 + 4 * beside.mean() * 24) / math.pi}
        if estimator != "R":
            out["account"] = result.light()["flux_direct"]["landed_w"] / math.pi
        return out

    figures, exact = both(measure, effort), truth.ball_transmitted(1.5)
    return [("ball lens n = 1.5", "share straight through, by pixels", exact, figures["pixels"],
             effort.blur(0.005 * exact)),
            ("ball lens n = 1.5", "share straight through, by flux account", exact, figures["account"], {})]


PROFILE_EDGES = np.array([0, 0.05, 0.09, 0.12, 0.135, 0.16, 0.19, 0.25])
# What P's kernel may move: from the bright side of the fold (40) to the dark one (0.2), mostly.
PROFILE_BLUR = [0.2, 0.3, 0.4, 1.5, 1.5, 0.4, 0.02]


def ball_profile(effort):
    """Irradiance just below the ball against radial quadrature, in annuli; the fold lies at r = 0.1484."""
    limits = {"total": 16, "diffuse": 4, "glossy": 0, "transmission": 16}
    size = 100
    s = scene(down_camera(0, 0, -1.02, 0.5, [size, size]), [plane("Floor", [4, 4], [0, 0, -1.05]), ball("Ball", 1, [0, 0, 0])],
              [sun([0, 0, -1])], limits)
    at = (np.arange(size) + 0.5) / size * 0.5 - 0.25
    radius = np.hypot(*np.meshgrid(at, at))
    names = [f"E, r {a:g} to {b:g}" for a, b in zip(PROFILE_EDGES, PROFILE_EDGES[1:])]
    ring = np.digitize(radius, PROFILE_EDGES) - 1
    exact_image = truth.ball_irradiance(1.5, 1.05, np.linspace(-0.25, 0.25, size + 1))

    def measure(estimator, seed):
        e, _ = direct(s, effort, estimator, seed, 4)
        return {name: e[ring == i].mean() for i, name in enumerate(names)}

    figures = both(measure, effort)
    rows = []
    for i, name in enumerate(names):
        exact = float(exact_image[ring == i].mean())
        rows.append(("ball lens, plane 1.05 R", name, exact, figures[name], effort.blur(PROFILE_BLUR[i])))
    return rows


# ---- slab, ior 1 ----

def slab_scene(material, direction, angle, limits=None):
    return scene(down_camera(0, 0, 0.05, 0.4, [16, 16]),
                 [plane("Floor", [8, 8], [0, 0, 0]), box("Slab", [1.5, 1.5, 0.1], [0, 0, 0.2], material)],
                 [sun(direction, angle=angle)], limits)


def slab(effort):
    rows = []
    for angle, word in ((0, "delta sun"), (60, "sun of 60 degrees")):
        for internal in (True, False):
            limits = None if internal else {"total": 16, "diffuse": 4, "glossy": 0, "transmission": 16}
            s = slab_scene("glass", [0, 0, -1], angle, limits)
            figures = both(lambda e, seed: {"T": direct(s, effort, e, seed)[0].mean()}, effort)["T"]
            exact = truth.slab(1.5, math.radians(angle / 2), internal)
            name = "all internal bounces" if internal else "no internal bounce"
            rows.append((f"slab n = 1.5, {word}", name, exact, figures, effort.blur(0.002)))
    return rows


def straight(effort):
    """ior 1 bends nothing: its caustic is the light itself, S cos of the angle."""
    rows = []
    for angle, word in ((0, "delta sun"), (50, "sun of 50 degrees")):
        s = slab_scene("air", [0.5, 0, -math.sqrt(0.75)], angle)
        figures = both(lambda e, seed: {"E": direct(s, effort, e, seed)[0].mean()}, effort)["E"]
        rows.append((f"ior 1, {word} at 30 degrees", "E = S cos 30", math.sqrt(0.75), figures, effort.blur(0.002)))
    return rows


# ---- mirror cylinder ----

def cylinder_scene(size):
    height = 0.6
    tube = {"name": "Tube", "shape": {"type": "cylinder", "radius": 1, "height": height}, "position": [0, 0, 0],
            "material": "mirror"}
    limits = {"total": 16, "diffuse": 4, "glossy": 0, "transmission": 16}
    return scene(down_camera(0.5, 0, 2, 1.2, [size, size]), [plane("Floor", [4, 4], [0, 0, 0]), tube],
                 [sun([1, 0, -1], strength=math.sqrt(2))], limits)


def brightest(profile, positions):
    """Centre of mass of what is over 70 % of the brightest: where a blurred caustic is."""
    weight = np.maximum(profile - 0.7 * profile.max(), 0)
    return float((weight * positions).sum() / weight.sum())


def nephroid(effort):
    """Pixels against forward mapping; where along the axis the cusp is; how far from the envelope the brightest
    pixels across it lie."""
    size = 120
    s, pixel = cylinder_scene(size), 1.2 / 120
    x_edges, y_edges = np.linspace(-0.1, 1.1, size + 1), np.linspace(0.6, -0.6, size + 1)
    exact = truth.nephroid_irradiance(0.6, x_edges, y_edges[::-1])[::-1]
    x, y = (x_edges[1:] + x_edges[:-1]) / 2, (y_edges[1:] + y_edges[:-1]) / 2
    inside = np.hypot(*np.meshgrid(x, y)) < 0.97

    def sample(image, px, py):
        return image[np.clip(((0.6 - py) / pixel).astype(int), 0, size - 1), np.clip(((px + 0.1) / pixel).astype(int), 0, size - 1)]

    def features(e):
        middle = e[size // 2 - 1:size // 2 + 1].mean(axis=0)
        near = (x > 0.35) & (x < 0.65)
        # Before the cusp one sheet of light, behind it three: where the axis is half as bright as its brightest.
        first = int(np.argmax(middle[near] > middle[near].max() / 2))
        before, behind = middle[near][first - 1:first + 1] / middle[near].max()
        rise = x[near][first - 1] + pixel * (0.5 - before) / (behind - before)
        out = {"mean E": e[inside].mean(), "cusp x": float(rise)}
        offsets, across = [], np.arange(-6, 6.01, 0.25) * pixel
        for t in np.radians([-40, -35, -30, 30, 35, 40]):
            px, py = truth.nephroid(t)
            # The reflected ray is tangent to the envelope; the profile runs at right angles to it.
            nx, ny = np.sin(2 * t), -np.cos(2 * t)
            profile = np.mean([sample(e, px + across * nx - d * np.cos(2 * t), py + across * ny - d * np.sin(2 * t))
                               for d in np.arange(-4, 5) * pixel / 2], axis=0)
            offsets.append(brightest(profile, across) / pixel * np.sign(t))
        out["envelope"] = float(np.mean(offsets))
        return out

    want = features(exact)
    figures = both(lambda e, seed: features(direct(s, effort, e, seed, 8)[0]), effort)
    return [("nephroid, mirror cylinder", "mean E over its floor", want["mean E"], figures["mean E"],
             effort.blur(0.004)),
            ("nephroid, mirror cylinder", "cusp (R/2 = 0.5; truth: in these pixels)", want["cusp x"], figures["cusp x"],
             effort.blur(1.5 * pixel)),
            ("nephroid, mirror cylinder", "off the envelope, in pixels (truth: in these pixels)",
             want["envelope"], figures["envelope"], effort.blur(1.0))]


# ---- closed mirror room ----

def room_scene(radius, size, color=1.0):
    mirror = {"type": "metal", "color": [color] * 3, "edge_color": [color] * 3, "roughness": 0}
    lamp = {"name": "Sun", "type": "point", "power_w": 4, "radius_m": radius,
            "look": {"from": [0.3, 0.2, 0.5], "to": [0.3, 0.2, 0]}}
    # The floor pierces the walls, so that there is no gap. It is dark, or R's paths would go on for a thousand bounces.
    return scene(down_camera(0, 0, 0.9, 2, [size, size]),
                 [box("Room", [2, 2, 1.125], [0, 0, 0.4375], "walls"), plane("Floor", [2.5, 2.5], [0, 0, 0], "dark")],
                 [lamp], materials={"walls": mirror, "dark": {"type": "diffuse", "color": [0.02] * 3}})


def room(effort):
    """All of a lamp's light in a closed room of mirrors falls on its floor; what does so by itself is known."""
    rows, size = [], 16
    at = (np.arange(size) + 0.5) / size * 2 - 1
    straight_share = truth.rectangle_solid_angle(-1.3, 0.7, -1.2, 0.8, 0.5) / (4 * math.pi)
    grid = np.meshgrid((np.arange(64) + 0.5) / 32 - 1, (np.arange(64) + 0.5) / 32 - 1)
    corner = float(4 * truth.mirror_room(1, 1, (0.3, 0.2, 0.5), *grid, reach=60)[:16, :16].mean())
    lost = 4 * truth.mirror_room_cut(1, 1, DEPTH_MAX)
    for radius, word in ((0, "point lamp"), (0.4, "lamp of radius 0.4")):
        s = room_scene(radius, size)

        def measure(estimator, seed):
            e, result = direct(s, effort, estimator, seed, 4 if radius and estimator == "R" else 1, 0.02)
            # Row 0 is the largest y: the corner of smallest x and y is at the bottom left.
            out = {"E": e.mean(), "corner": e[-4:, :4].mean()}
            if estimator != "R":
                flux = result.light()["flux_direct"]
                out["account"] = flux["landed_w"] + flux["dropped_w"]
            return out

        figures = both(measure, effort)
        total = 4 * (1 - straight_share)
        name = f"closed mirror room, {word}"
        rows.append((name, "mean E", total / 4 - lost, figures["E"], {"P": 0.004}))
        if not radius:
            rows.append((name, "E in the far corner, by images", corner - lost, figures["corner"], {"P": 0.01}))
        rows.append((name, "landed + dropped, W, by flux account", total, figures["account"], {}))
    return rows


# ---- white furnace ----

def furnace_scene(size=16):
    """Nothing absorbs, the world is 1 everywhere: so is every pixel of beauty plus layers."""
    camera = {"type": "perspective", "look": {"from": [0, -3, 2], "to": [0, 0, 0.4]}, "hfov_deg": 40,
              "resolution": [size, size], "filter": {"type": "box", "width": 1}}
    return scene(camera, [plane("Floor", [2, 2], [0, 0, 0]), ball("Glass", 0.35, [-0.35, 0, 0.5]),
                          ball("Metal", 0.25, [0.4, 0.3, 0.4], "mirror")], [], world=1.0)


def furnace(effort):
    s = furnace_scene()

    def measure(estimator, seed):
        n = effort.words("R", seed, 4)
        beauty = run(s, *n, "--layers", "beauty,radiance,indirect")
        layers = beauty if estimator == "R" else run(s, *effort.words("P", seed + 100, 2), "--layers", "radiance,indirect")
        extra = layers["caustics_world"] + layers["caustics_world_ind"]
        pixels = beauty["beauty"] + extra
        floor = slice(11, 15), slice(5, 11)
        return {"all": pixels.mean(), "floor": pixels[floor].mean(), "extra": extra.mean()}

    figures = both(measure, effort, "PR")
    share = figures["extra"]["R"].mean
    return [("white furnace", f"beauty + layers, picture (layers {share:.3f})", 1.0, figures["all"], effort.blur(0.004)),
            ("white furnace", "beauty + layers, floor before the balls", 1.0, figures["floor"],
             effort.blur(0.02))]


CASES = [ball_transmitted, ball_profile, slab, straight, nephroid, room, furnace]
