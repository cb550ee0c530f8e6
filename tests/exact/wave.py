# SPDX-License-Identifier: Apache-2.0
"""W's coarse grids have a fine grid's light: what a triangle's corners do not tell, and what a receiver that is seen
refuses of a triangle, is carried by single rays. Means over many random shifts of the grid, against closed forms."""
import math
import os

import numpy as np

import truth
from rig import FOLDER, Check, Figure, ball, blocks, down_camera, look_camera, over_seeds, plane, run, scene, sun

RAYS = int(2e4 * float(os.environ.get("EFFORT", "1")))
SEEDS = range(1, 6)


def tiles_file(count, size, gap):
    """A square of count x count loose tiles around the origin, one mesh."""
    path = os.path.join(FOLDER.name, "tiles.obj")
    with open(path, "w") as file:
        for k in range(count * count):
            x, y = (size * (v - count / 2) + gap / 2 for v in (k % count, k // count))
            a, b = x + size - gap, y + size - gap
            for corner in ((x, y), (a, y), (a, b), (x, b)):
                file.write(f"v {corner[0]} {corner[1]} 0\n")
        for k in range(count * count):
            file.write("f " + " ".join(str(4 * k + i) for i in (1, 2, 3, 4)) + "\n")
    return os.path.basename(path)


def green(s, seed, rays):
    result = run(s, "--estimator", "W", "--photons", rays, "--seed", seed, "--effects", "direct", "--layers", "radiance")
    return math.pi * result["caustics_Sun"][:, :, 1]


def gaps(check):
    """Loose tiles over grout, lit through a sheet of ior 1, seen directly and through another such sheet: most triangles
    of light reach over a gap, and none of their light is lost there. Gaps of half a pixel and of 2/7; shallow, a part of
    the sheet, or so deep that a triangle on the tiles does not light them: rays alone do, with more noise. Through the
    sheet by photons, whose kernels lose a part of the light that lies along an edge alone."""
    for words, height, depth, bias, sharp in (("shallow gaps", 0.5, 0.0005, 0.0005, 0.001), ("deep gaps", 0.5, 0.01, 0.01, 0.02),
                                              ("shallow gaps through the sheet", 2, 0.0005, 0.0005, 0.001),
                                              ("deep gaps through the sheet", 2, 0.01, 0.05, 0.02)):
        for pixels in (26, 15):
            objects = [{"name": "Tiles", "file": tiles_file(8, 0.125, 0.025), "material": "white", "smooth": False},
                       plane("Grout", [4, 4], [0, 0, -depth]), plane("Sheet", [2.5, 2.5], [0, 0, 1], "air")]
            s = scene(down_camera(0, 0, height, 1.3, [pixels, pixels]), objects, [sun([0, 0, -1])])
            # Through the sheet at 15 pixels: triangles so small that kernels spread them.
            rays = 40 * RAYS if height == 2 and pixels == 15 else RAYS
            figures = over_seeds(SEEDS, lambda seed: {"mean": green(s, seed, rays).mean()})
            check.close(f"loose tiles, {words}, {pixels} pixels, mean", figures["mean"], 1.0, bias, sharp)


def thin_wall(check):
    """A wall without thickness on the floor, in slanting light, seen from its dark side: the floor there stays dark up to
    the wall's foot, though triangles of light on the far side lie in the same pixels. By a filter with subpixels and by
    one without."""
    for kind in ("box", "blackman_harris"):
        wall = plane("Wall", [1, 4], [0, 0, 0.5], rotation=[0, 90, 0])
        camera = {**look_camera([1.53, 0, 2], [0.03, 0, 0], 2, [11, 11]), "filter": {"type": kind, "width": 1}}
        s = scene(camera, [plane("Floor", [4, 4], [0, 0, 0]), wall, plane("Sheet", [3, 3], [-1.5, 0, 3], "air")],
                  [sun([1, 0, -2])])
        pictures = np.array([green(s, seed, 10 * RAYS) for seed in SEEDS[:3]])
        foot = np.abs(pictures[:, 3:6]).max()
        check.that(foot < 1e-3, f"thin wall, {kind}: {foot:.1e} of the light behind it shows on it and at its foot (1e-3)")
        check.close(f"thin wall, {kind}, beyond its shadow", Figure(pictures[:, 9].mean(axis=1)), 2 / math.sqrt(5), 0.0005, 0.0005)


def rings(check):
    """The faint rings beyond the fold of a ball lens, on a plane just below it: less than a cell of the grid sends
    their light, through the ball's rim, over a wide stretch of the plane."""
    edges, size = np.array([0.16, 0.19, 0.25]), 100
    limits = {"total": 16, "diffuse": 4, "glossy": 0, "transmission": 16}
    s = scene(down_camera(0, 0, -1.02, 0.5, [size, size]), [plane("Floor", [4, 4], [0, 0, -1.05]), ball("Ball", 1, [0, 0, 0])],
              [sun([0, 0, -1])], limits)
    at = (np.arange(size) + 0.5) / size * 0.5 - 0.25
    ring = np.digitize(np.hypot(*np.meshgrid(at, at)), edges) - 1
    exact = truth.ball_irradiance(1.5, 1.05, np.linspace(-0.25, 0.25, size + 1))

    def measure(seed):
        e = green(s, seed, 40 * RAYS)  # in 16 passes
        return {f"ring {edges[i]:g} to {edges[i + 1]:g}": e[ring == i].mean() for i in range(2)}

    for i, (name, figure) in enumerate(over_seeds(SEEDS, measure).items()):
        check.close(f"ball lens, {name}", figure, float(exact[ring == i].mean()), 0.004 * exact[ring == i].mean(), 0.01)


def round_and_round(check):
    """Wide rings of the plane below a ball. A hundredth of their light has gone round inside at grazing angles, and lost
    little at each of many reflections: roulette by their number would all but never find it."""
    edges, size = np.array([1.4, 2, 3]), 60
    limits = {"total": 64, "diffuse": 4, "glossy": 64, "transmission": 64}
    s = scene(down_camera(0, 0, -1.02, 6, [size, size]), [plane("Floor", [8, 8], [0, 0, -1.05]), ball("Ball", 1, [0, 0, 0])],
              [sun([0, 0, -1])], limits)
    fine = np.linspace(1.2, 5, 400)
    at = (np.arange(4 * size) + 0.5) / (4 * size) * 6 - 3
    exact = np.interp(np.hypot(*np.meshgrid(at, at)), (fine[1:] + fine[:-1]) / 2, truth.ball_rings(1.5, 1.05, fine))
    exact = blocks(exact, 4)
    at = (np.arange(size) + 0.5) / size * 6 - 3
    ring = np.digitize(np.hypot(*np.meshgrid(at, at)), edges) - 1

    def measure(seed):
        e = green(s, seed, 3 * RAYS)
        return {f"ring {edges[i]:g} to {edges[i + 1]:g}": e[ring == i].mean() for i in range(2)}

    for i, (name, figure) in enumerate(over_seeds(SEEDS, measure).items()):
        e = float(exact[ring == i].mean())
        check.close(f"ball, light from inside, {name}", figure, e, 0.002 * e, 0.005)


def focus_through_a_pane(check):
    """A ball's focus, smaller than a pixel, through a pane that does not bend light: as without the pane. Few of the eye
    paths by which W shows what lies behind glass meet it, and a kernel of a pixel's width blurs it."""
    at, size = [0, -3, 2], [40, 30]
    camera = look_camera(at, [0, 0, 0], 0.6, size)
    things = [plane("Floor", [4, 4], [0, 0, 0]), ball("Ball", 0.5, [0, 0, 0.75])]
    tilt = math.degrees(math.atan2(at[2], -at[1]))
    pane = plane("Pane", [1, 1], [0.9 * c for c in at], "air", rotation=[90 - tilt, 0, 0])
    bare, behind = (np.array([green(scene(camera, objects, [sun([0, 0, -1])]), seed, 2 * RAYS) for seed in SEEDS[:4]])
                    for objects in (things, [*things, pane]))
    truth_here = bare.mean(axis=0)
    error = np.sqrt(((behind - truth_here) ** 2).mean() / (truth_here**2).mean())
    check.that(error < 0.02, f"focus through a pane: differs by {100 * error:.2f} % RMSE / RMS from without it (2)")


def noisy_sheet(check):
    """A sheet of water whose waves are as short as the grid's cells: no three corners tell what lies between them, and the
    picture is what single rays bring. Its noise is that of as many photons, not of a sixteenth of them."""
    waves = [{"amplitude": 0.001, "k": 60 + 7 * i, "direction_rad": 0.9 * i, "phase": 1.3 * i} for i in range(7)]
    sheet = {"name": "Sheet", "shape": {"type": "heightfield", "size": [2, 2], "waves": waves}, "position": [0, 0, 0.6],
             "material": "glass"}
    s = scene(down_camera(0, 0, 0.4, 0.8, [24, 24]), [plane("Floor", [4, 4], [0, 0, 0]), sheet], [sun([0, 0, -1])])
    pictures = np.array([green(s, seed, RAYS) for seed in SEEDS])
    noise = math.sqrt(pictures.var(axis=0, ddof=1).mean()) / pictures.mean()
    check.that(noise < 0.17, f"sheet of short waves, {RAYS} rays: {100 * noise:.1f} % noise (17)")


if __name__ == "__main__":
    found = Check()
    gaps(found)
    thin_wall(found)
    rings(found)
    round_and_round(found)
    focus_through_a_pane(found)
    noisy_sheet(found)
    found.end()
