# SPDX-License-Identifier: Apache-2.0
"""Coarse meshes with interpolated normals: Cycles, and R, bend a normal that would mirror the eye's direction into the
surface; what P makes of it must have the same mean. Each case is one way that P has for such a vertex, and each differs
by several per cent when photons take the normals as they are. W has the smooth ones: all but paths over a bent mirror, which
photons bring; and without a lamp's extent nothing bends, so that a coarse grid must bring the energy of a fine one.
Argument: effort."""
import math
import sys

from rig import Check, Figure, down_camera, plane, run, scene, sun

MATERIALS = {
    "rough mirror": {"type": "metal", "color": [1, 1, 1], "edge_color": [1, 1, 1], "roughness": 0.3},
    "mirror": {"type": "metal", "color": [1, 1, 1], "edge_color": [1, 1, 1], "roughness": 0},
    "rough glass": {"type": "glass", "color": [1, 1, 1], "ior": 1.5, "roughness": 0.1},
    "glass": {"type": "glass", "color": [1, 1, 1], "ior": 1.5, "roughness": 0},
}


def coarse_ball(material, angle=60):
    """Eight sides, and a sun wide enough for R to find."""
    body = {"name": "Ball", "shape": {"type": "sphere", "radius": 0.5, "segments": 8}, "smooth": True,
            "position": [0, 0, 0.7], "material": "caster", "visible_to": ["diffuse", "glossy", "transmission", "shadow"],
            "visible_to_camera": False}
    return scene(down_camera(0, 0, 3, 3, [16, 16]), [plane("Floor", [4, 4], [0, 0, 0]), body],
                 [sun([0.5, 0, -1], 2, angle)], materials={"caster": material})


def jar(angle):
    """Smooth normals over edges of 90 degrees: part of its light is mirrored by bent ones."""
    body = {"name": "Jar", "shape": {"type": "lathe", "profile": [[0, 0], [0.3, 0], [0.3, 0.7], [0, 0.7]], "segments": 64},
            "smooth": True, "position": [0, 0, 0.2], "material": "caster", "visible_to_camera": False}
    return scene(down_camera(0, 0, 3, 3, [16, 16]), [plane("Floor", [4, 4], [0, 0, 0]), body],
                 [sun([0.5, 0, -1], 2, angle)], materials={"caster": MATERIALS["glass"]})


def means(case, estimator, count, seeds):
    return Figure([run(case, "--estimator", estimator, "--photons", count, "--seed", seed, "--effects", "direct",
                       "--layers", "radiance")["caustics_Sun"].mean() for seed in seeds])


if __name__ == "__main__":
    found = Check()
    effort = float(sys.argv[1]) if len(sys.argv) > 1 else 1
    for name, material in MATERIALS.items():
        case = coarse_ball(material)
        p, r = means(case, "P", int(4e4 * effort), range(1, 9)), means(case, "R", int(1.2e5 * effort), range(51, 55))
        ratio, error = p.mean / r.mean, math.hypot(p.error, r.error) / r.mean
        # P's kernel smooths over the picture's rim, too: half a per cent.
        found.that(abs(ratio - 1) <= 0.005 + 3 * error, f"{name}: P/R {ratio:.4f} +- {error:.4f}")
        found.that(error <= 0.04, f"{name}: the error is small enough to tell")
        if "rough" in name:
            continue
        w = means(case, "W", int(6e4 * effort), range(1, 5))
        ratio, error = w.mean / r.mean, math.hypot(w.error, r.error) / r.mean
        found.that(abs(ratio - 1) <= 3 * error, f"{name}: W/R {ratio:.4f} +- {error:.4f}")
        found.that(error <= 0.04, f"{name}: W's error is small enough to tell")
        case = coarse_ball(material, 0)
        coarse, fine = means(case, "W", int(1e4 * effort), range(1, 25)), means(case, "W", int(4e5 * effort), range(1, 5))
        ratio, error = coarse.mean / fine.mean, math.hypot(coarse.error, fine.error) / fine.mean
        found.that(abs(ratio - 1) <= 3 * error, f"{name}: W's coarse grid/fine grid {ratio:.4f} +- {error:.4f}")
        found.that(error <= 0.01, f"{name}: the grids' error is small enough to tell")
    p, r = means(jar(60), "P", int(4e4 * effort), range(1, 9)), means(jar(60), "R", int(5e5 * effort), range(51, 55))
    ratio, error = p.mean / r.mean, math.hypot(p.error, r.error) / r.mean
    found.that(abs(ratio - 1) <= 0.005 + 3 * error, f"jar, wide sun: P/R {ratio:.4f} +- {error:.4f}")
    # Looked for evenly, a sun of 4 degrees is on one direction in thousands, and the error is three times as large.
    p = means(jar(4), "P", int(4e4 * effort), range(1, 13))
    found.that(p.error <= 0.02 * p.mean, f"jar, narrow sun: P {p.mean:.5f} +- {100 * p.error / p.mean:.1f} %, found where it grazes")
    found.end()
