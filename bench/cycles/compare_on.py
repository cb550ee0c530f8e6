#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""The caustic layers against what Cycles' own caustics add.

  compare_on.py [--photons N] [--seeds K] [-o TABLE.tsv] [--page FILE.md] [--pictures FOLDER] [NAME...]

NAME.exr in reference/ is the mean of (caustics on - caustics off) by Cycles, NAME.GROUP.exr that of one light group. The
default estimator renders direct and indirect layers at the reference's size, K times with other random numbers: the
spread of the K gives our own standard error. A scene passes when the means differ by at most 2 % + 2 standard errors of
both (3 % for plastic_room: see docs/cycles.md). Blocks of 8x8 pixels: the share beyond
2 % + 3 standard errors, and the one farthest out. CPU seconds: Cycles' of all its renders with caustics on, whose noise
is the reference's, ours of one render. Exit code 1 when a scene fails.

CAUSTIC_RENDER names the program; else build/bin/caustic-render."""
import argparse
import csv
import math
import os
import sys

from compare_common import (REFERENCES, Picture, block_error, blocks, magnify, markdown, np, put_into_page, render,
                            scene_file, side_by_side, worst_block, write_png, write_table)

COLUMNS = ["scene", "layers of", "mean ours / Cycles", "Cycles' standard error, %", "ours, %", "verdict",
           "blocks beyond 2 % + 3 sigma", "worst block: row, column", "its difference, %", "its sigma, %",
           "our CPU s", "Cycles' CPU s", "Cycles' samples"]
RELATIVE, SIGMAS, BLOCK_SIGMAS = {"plastic_room": 0.03}, 2.0, 3.0
# Blocks darker than this share of the picture's mean say little.
DARK = 0.1


def table_of_references():
    with open(os.path.join(REFERENCES, "table.tsv"), encoding="utf-8") as file:
        return {row["file"][:-4]: row for row in csv.DictReader(file, delimiter="\t")}


def layers_of(picture, group):
    """The sum of the layers, or those of one light group."""
    if not group:
        return picture.layer()
    names = (f"caustics_{group}", f"caustics_{group}_ind")
    return sum(picture.layer(n) for n in picture.layers() if n in names)


class Renders:
    """K renders of a scene, kept while the scene's references are gone through."""

    def __init__(self, photons, seeds):
        self.photons, self.seeds, self.key = photons, seeds, None

    def of(self, scene, size):
        if self.key != (scene, size):
            runs = [render(scene_file(scene), size, "--effects", "direct,indirect", "--layers", "radiance,indirect",
                           "--photons", self.photons, "--seed", 1000 + k) for k in range(self.seeds)]
            self.key, self.pictures = (scene, size), [run[0] for run in runs]
            self.seconds = sum(run[1]["cpu_s"] for run in runs) / len(runs)
        return self.pictures


def compare(name, row, runs, reference):
    """Figures of one reference. runs: (seeds, height, width, 3)."""
    theirs, theirs_error = reference.layer(), reference.layer("se")
    k, ours = len(runs), runs.mean(0)
    allowed = RELATIVE.get(name, 0.02)
    mean, mean_error = float(theirs.mean()), float(row["se_of_mean"])
    ours_mean_error = float(runs.mean((1, 2, 3)).std(ddof=1)) / math.sqrt(k)
    total = math.hypot(mean_error, ours_mean_error)
    # A block's spread over few seeds is a rough guess: at least that of its neighbourhood.
    spread = np.stack([blocks(r) for r in runs]).std(0, ddof=1) / math.sqrt(k)
    error = np.hypot(block_error(theirs_error), np.maximum(spread, np.sqrt((spread ** 2).mean()) * .3))
    d, c = blocks(ours - theirs), blocks(theirs)
    bright = c.mean(-1) > DARK * mean
    beyond = (np.abs(d.mean(-1)) > allowed * c.mean(-1) + BLOCK_SIGMAS * error.mean(-1)) & bright
    same = abs(float(ours.mean()) - mean) <= allowed * mean + SIGMAS * total
    return {"ratio": float(ours.mean()) / mean, "theirs_error": mean_error / mean, "pass": same,
            "ours_error": ours_mean_error / mean, "difference": d, "blocks": c, "error": error,
            "beyond": int(beyond.sum()), "bright": int(bright.sum()), "map": beyond,
            "worst": worst_block(d, c, error, allowed, DARK * mean)}


def row_of(name, group, figures, seconds, reference_row):
    def percent(x):
        return f"{100 * x:.2f}"
    (at_row, at_column), d, c, e = figures["worst"]
    return [name, group or "all", f"{figures['ratio']:.4f}", percent(figures["theirs_error"]),
            percent(figures["ours_error"]), "pass" if figures["pass"] else "FAIL",
            f"{figures['beyond']} of {figures['bright']}",
            f"{at_row}, {at_column}", f"{100 * d / c:+.1f}", f"{100 * e / c:.1f}", f"{seconds:.0f}",
            f"{float(reference_row['cpu_s_on']):.0f}", f"{reference_row['seeds']} x {reference_row['spp']}"]


def picture(path, off, layers, added):
    """Cycles off, the layers, Cycles off + layers, Cycles on."""
    exposure = .8 / float(np.percentile(off + added, 95))
    images = [off, layers, off + layers, off + added]
    write_png(path, side_by_side([magnify(i * exposure, 3) for i in images]))


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("names", nargs="*", metavar="NAME")
    p.add_argument("--photons", type=int, default=1000000, help="per light and seed")
    p.add_argument("--seeds", type=int, default=4)
    p.add_argument("-o", "--out", help="the table as TSV")
    p.add_argument("--page", help="a page with the marker \"on\" for the table")
    p.add_argument("--pictures", help="a folder for a PNG of each scene")
    p.add_argument("--blocks", action="store_true", help="print every block that is beyond its limit")
    a = p.parse_args()
    table, rows, failed, renders = table_of_references(), [], [], Renders(a.photons, a.seeds)
    print("\t".join(COLUMNS))
    for name in a.names or sorted(table):
        stem, _, group = name.partition(".")
        reference = Picture(os.path.join(REFERENCES, name + ".exr"))
        try:
            pictures = renders.of(stem, reference.layer().shape[:2])
        except RuntimeError as error:
            print(f"{name}: not run: {error}")
            failed.append(name)
            continue
        figures = compare(name, table[name], np.stack([layers_of(x, group) for x in pictures]), reference)
        if not figures["pass"]:
            failed.append(name)
        rows.append(row_of(stem, group, figures, renders.seconds, table[name]))
        print("\t".join(rows[-1]), flush=True)
        if a.blocks:
            for i, j in np.argwhere(figures["map"]):
                d, c, e = (figures[k][i, j].mean() for k in ("difference", "blocks", "error"))
                print(f"  block {i}, {j}: Cycles {c:.5f}, P {c + d:.5f}, {100 * d / c:+.1f} %, sigma {100 * e / c:.1f} %")
        if a.pictures and not group:
            picture(os.path.join(a.pictures, f"cycles_{name}.png"), reference.layer("off"), layers_of(pictures[0], ""),
                    reference.layer())
    print(f"failed: {' '.join(failed)}" if failed else "all pass")
    if a.out:
        write_table(a.out, COLUMNS, rows)
    if a.page:
        put_into_page(a.page, "on", markdown(COLUMNS, rows))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
