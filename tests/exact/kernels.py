# SPDX-License-Identifier: Apache-2.0
"""P's kernels at edges, corners and thin walls. A sheet of ior 1 makes evenly spread light a caustic."""
import math
import os

import numpy as np

from rig import Check, Figure, box, down_camera, look_camera, plane, run, scene, sun

PHOTONS = int(150000 * float(os.environ.get("EFFORT", "1")))


def irradiance(s, seed, photons=PHOTONS):
    r = run(s, "--estimator", "P", "--photons", photons, "--seed", seed, "--effects", "direct", "--layers", "radiance")
    return math.pi * r["caustics_Sun"][:, :, 1]


def square(check):
    """Evenly lit square, the picture's edges are its edges: edge and corner pixels within 2 % of the centre. Another one just
    behind it (grout behind tiles) or in the same plane (a wall and the block that stands on it) adds no surface to see."""
    n, tile = 16, [[x, y] for x in (-0.25, 0.25) for y in (-0.25, 0.25)]
    front = [plane("Square", [1, 1], [0, 0, 0])]
    tiles = [plane(f"Tile{i}", [0.49, 0.49], [x, y, 0.002]) for i, (x, y) in enumerate(tile)]
    for name, objects in (("square", front), ("square before another", front + [plane("Below", [1, 1], [0, 0, -0.002])]),
                          ("two squares in one plane", front + [plane("Same", [1, 1], [0, 0, 0])]), ("tiles", front + tiles)):
        s = scene(down_camera(0, 0, 0.5, 1, [n, n]), objects + [plane("Sheet", [1.1, 1.1], [0, 0, 1], "air")], [sun([0, 0, -1])])
        edges, corners, centres = [], [], []
        for seed in range(1, 9):
            e = irradiance(s, seed)
            centres.append(e[4:12, 4:12].mean())
            edges.append(np.mean([e[0, 2:-2], e[-1, 2:-2], e[2:-2, 0], e[2:-2, -1]]))
            corners.append(np.mean([e[0, 0], e[0, -1], e[-1, 0], e[-1, -1]]))
        check.close(f"{name}, centre", Figure(centres), 1.0, 0.002, 0.004)
        check.close(f"{name}, edge pixels", Figure(edges), 1.0, 0.02, 0.007)
        check.close(f"{name}, corner pixels", Figure(corners), 1.0, 0.02, 0.01)


def strips(check):
    """Long tiles lifted over their grout. Slanted light leaves part of the gaps in shadow, and some of it lands behind the
    tiles' edges; a slanted view of light straight down sees dark grout behind the edges. Neither is the tiles' light.
    Walls along the strips, which shade nothing, make kernels look at them by rays: in corridors as narrow as the kernels, 24 rays
    tell the surface with so much noise that one over it is a per cent too large."""
    pitch, gap, down, slanted = 0.1, 0.04, [0, 0, -1], [3, 0, -1]
    rows, walls = 1.5 / math.sqrt(10), [box(f"Wall{y}", [2.4, 0.01, 0.2], [0, y, 0.1], "white") for y in (-0.205, 0.205)]
    for name, lift, shift, direction, view, width, shape, more, bias in (
            ("slanted light", 0.02, 0.02, [1, 0, -1], down, 1, [16, 16], [], 0.003),
            ("slanted view", 0.005, 0.015, down, slanted, rows, [16, 16], [], 0.003),
            ("slanted light between walls", 0.02, 0.02, [1, 0, -1], down, 0.4, [8, 20], walls, 0.01),
            ("slanted view between walls", 0.005, 0.015, down, slanted, 0.4, [16, 19], walls, 0.01)):
        camera = look_camera([-0.3 * d for d in view], [0, 0, 0], width, shape)
        tiles = [plane(f"Tile{i}", [pitch - gap, 2.4], [(i + 0.5) * pitch, 0, lift]) for i in range(-12, 12)]
        s = scene(camera, [plane("Grout", [2.4, 2.4], [0, 0, 0]), plane("Sheet", [6, 6], [0, 0, 1], "air")] + tiles + more, [sun(direction)])
        truth = -direction[2] / math.hypot(*direction) * (pitch - shift) / pitch
        mean = Figure([irradiance(s, seed).mean() for seed in range(1, 9)])
        check.close(f"strips of tiles, {name}", mean, truth, bias * truth, 0.005)


def far_side(check):
    """The dark side of what is lit from above: exactly black, also where it is another sheet a hair below."""
    for gap in (None, 1e-4, 1e-6):
        objects = [plane("Top", [1, 1], [0, 0, 0]), plane("Sheet", [1.1, 1.1], [0, 0, 1], "air")]
        if gap:
            objects.append(plane("Below", [1, 1], [0, 0, -gap]))
        s = scene(look_camera([0, 0, -1], [0, 0, 0], 1, [16, 16]), objects, [sun([0, 0, -1])])
        leak = irradiance(s, 1).max()
        check.that(leak == 0, f"far side of a thin wall, {'itself' if gap is None else f'{gap:g} m below'}: leak {leak:g}")


def wall_scene(thickness, direction, camera, height=0.5):
    wall = (plane("Wall", [height, 2], [0, 0, height / 2], rotation=(0, 90, 0)) if thickness == 0
            else box("Wall", [thickness, 2, height], [0, 0, height / 2], "white"))
    return scene(camera, [plane("Floor", [2, 2], [0, 0, 0]), wall, plane("Sheet", [4, 4], [0, 0, 1], "air")], [sun(direction)])


def corner(check):
    """Floor and wall. Light straight down: even light up to the wall on both sides, none on the wall. Light from one
    side: the floor behind the wall is black, lit floor and wall are even up to their corner."""
    n, away = 40, math.sqrt(0.5)
    for thickness in (0, 0.002):
        name = "thin wall" if thickness == 0 else "wall of 2 mm"
        floor = down_camera(0, 0, 0.9, 1, [n, n])
        even = np.mean([irradiance(wall_scene(thickness, [0, 0, -1], floor), k) for k in range(1, 5)], axis=0)
        far = even[:, 4:12].mean()
        for column in (n // 2 - 1, n // 2):
            rim = even[:, column].mean()
            check.that(abs(rim / far - 1) < 0.04, f"{name}: floor beside it, column {column}: {rim / far:.4f} of the floor afar")
        side = look_camera([-0.5, 0, 0.25], [0, 0, 0.25], 1, [n, n // 2])
        check.that(irradiance(wall_scene(thickness, [0, 0, -1], side), 1).max() == 0, f"{name}: grazing light gives the wall nothing")
        # Light flies to +x and down: the floor at 0 < x < 0.9 lies in the wall's shadow, whose far end may blur.
        slanted = [irradiance(wall_scene(thickness, [1, 0, -1], floor, 0.9), k) for k in range(1, 5)]
        leak = max(e[:, n // 2 + (thickness > 0):].max() for e in slanted)
        check.that(leak == 0, f"{name}: the floor behind it gets {leak:g}")
        lit = np.mean(slanted, axis=0)
        rim = lit[:, n // 2 - 1].mean() / lit[:, 4:12].mean()
        check.that(abs(rim - 1) < 0.04, f"{name}: lit floor at its foot: {rim:.4f} of the floor afar")
        face = np.mean([irradiance(wall_scene(thickness, [1, 0, -1], side), k) for k in range(1, 5)], axis=0)
        foot, middle = face[-1].mean() / face[4:12].mean(), face[4:12].mean()
        check.that(abs(foot - 1) < 0.04 and abs(middle / away - 1) < 0.02,
                   f"{name}: its lit side {middle:.4f} (cos 45 = {away:.4f}), at its foot {foot:.4f} of that")
        back = look_camera([0.5, 0, 0.25], [0, 0, 0.25], 1, [n, n // 2])
        check.that(irradiance(wall_scene(thickness, [1, 0, -1], back), 1).max() == 0, f"{name}: its other side is black")


def fine_tube(check):
    """Light in a tube whose wall is meshed far finer than the kernel: none outside; and outside light: none inside."""
    rings = [[0.3, 0.5 * k / 60] for k in range(61)]
    tube = {"name": "Tube", "shape": {"type": "lathe", "profile": rings, "segments": 256}, "position": [0, 0, 0], "material": "white"}
    n, at = 40, (np.arange(40) + 0.5) / 40 - 0.5
    radius = np.hypot(*np.meshgrid(at, at))
    # Half a pixel's diagonal, so that no pixel sees both sides.
    for name, inner, outer, dark in (("inside", 0, 0.28, radius > 0.32), ("outside", 0.32, 0.6, radius < 0.28)):
        sheet = {"name": "Sheet", "shape": {"type": "lathe", "profile": [[inner, 0], [outer, 0]], "segments": 128},
                 "position": [0, 0, 1], "material": "air"}
        s = scene(down_camera(0, 0, 0.9, 1, [n, n]), [plane("Floor", [2, 2], [0, 0, 0]), tube, sheet], [sun([0, 0, -1])])
        e = irradiance(s, 1)
        check.that(e[dark].max() == 0 and e[~dark].max() > 0.9, f"fine tube, light {name}: leak {e[dark].max():.3g} of 1 (mean {e[dark].mean():.2g})")


def fine_sheet(check):
    """A finely meshed sheet of ior 1 that nearly touches the floor: even light below it, seen through it."""
    rings = [[0.25 * k / 60, 0] for k in range(61)]
    sheet = {"name": "Sheet", "shape": {"type": "lathe", "profile": rings, "segments": 256}, "position": [0, 0, 1e-4], "material": "air"}
    s = scene(down_camera(0, 0, 0.5, 0.3, [16, 16]), [plane("Floor", [1, 1], [0, 0, 0]), sheet], [sun([0, 0, -1])])
    e = irradiance(s, 1)
    check.that(abs(e.mean() - 1) < 0.02 and 0.7 < e.min() and e.max() < 1.3,
               f"fine sheet on the floor: mean {e.mean():.4f}, {e.min():.3f} to {e.max():.3f}")


if __name__ == "__main__":
    found = Check()
    square(found)
    strips(found)
    far_side(found)
    corner(found)
    fine_tube(found)
    fine_sheet(found)
    found.end()
