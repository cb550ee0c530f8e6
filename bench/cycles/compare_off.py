#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Our reference path tracer against Cycles, both without caustics, pixel by pixel.

  compare_off.py [--spp N] [--seed K] [-o TABLE.tsv] [--page FILE.md] [--pictures FOLDER] [NAME...]

Estimator R renders what Cycles renders with caustics off, at the size of tests/data/cycles/NAME.exr. A value (a channel
of a pixel) is outside when |R - Cycles| > 1 % of Cycles + 2 standard errors of both + the rim. The rim is 4/1024 of what
the pixels around have more: Cycles draws filter offsets from a table of 1024 entries, and the last one spreads its
share evenly out to the filter's end, where a Gaussian has nothing left. A scene passes when no more values
are outside than chance puts there (plus 3 in a thousand: eight seeds know their own spread to a quarter), and the
means differ by no more than 1 % + 2 standard errors. Exit code 1 when a scene fails that no known difference explains.

CAUSTIC_RENDER names the program; else build/bin/caustic-render."""
import argparse
import os
import sys

from compare_common import (BEAUTIES, Picture, around, block_error, blocks, chance_outside, magnify, markdown,
                            mean_error, np, put_into_page, render_off, scene_file, side_by_side, worst_block,
                            write_png, write_table)

RELATIVE, SIGMAS, RIM, OUTLIERS = 0.01, 2.0, 4 / 1024, 0.003
COLUMNS = ["scene", "samples per pixel", "values outside, %", "by chance, %", "mean R / Cycles", "its 2 sigma, %",
           "worst 8x8 block: row, column", "its difference, %", "its 2 sigma, %", "CPU s", "verdict"]
DISC = ("Cycles 3.4's point lamp of radius r is a disc that faces the receiver, ours is a ball: up to (r / d)^2 more light "
        "at the distance d")
PLASTIC = "in Cycles 3.4 nodes can only weigh a coat with its Fresnel term at the normal, not at the half vector"
# Highlights of small lamps are rare finds for a path tracer: more samples. A black picture needs few.
FACTOR = {"filter_box": 8, "filter_gauss": 8, "filter_bh": 8, "a_ball": 4, "c_water": 1 / 64}
KNOWN = {
    "exposure2": DISC,
    "cards": DISC,
    "plastic": PLASTIC,
    "plastic_rough": PLASTIC,
    "rough": "Cycles 3.4 takes the Fresnel term of rough glass at the normal; " + PLASTIC,
    "emission": "mesh lights are not yet supported",
}


def names_of_all():
    stems = sorted(n[:-4] for n in os.listdir(BEAUTIES) if n.endswith(".exr"))
    return [n for n in stems if scene_file(n)]


def compare(ours, ours_error, theirs, theirs_error):
    """Figures of one scene as a dictionary."""
    difference, error = ours - theirs, np.hypot(ours_error, theirs_error)
    rim = RIM * np.maximum(around(theirs, 3) - theirs, 0)
    outside = np.abs(difference) > RELATIVE * np.abs(theirs) + SIGMAS * error + rim
    chance = chance_outside(theirs, error, RELATIVE, SIGMAS)
    mean, sigma = float(theirs.mean()), mean_error(error)
    # Neighbours' errors go together where the filter is wide: as if a quarter of the values were independent.
    noise = 3 * (chance * (1 - chance) / (outside.size / 4)) ** .5
    same_mean = abs(float(difference.mean())) <= RELATIVE * mean + SIGMAS * sigma
    return {"outside": float(outside.mean()), "chance": chance, "map": outside, "mean": mean, "sigma": sigma,
            "ratio": float(ours.mean()) / mean if mean > 0 else None,
            "worst": worst_block(blocks(difference), blocks(theirs), block_error(error), RELATIVE, .02 * mean),
            "pass": same_mean and float(outside.mean()) <= chance + noise + OUTLIERS}


def row_of(name, spp, figures, seconds, verdict):
    def percent(x):
        return f"{100 * x:.2f}"
    row = [name, spp, percent(figures["outside"]), percent(figures["chance"])]
    if figures["ratio"]:
        row += [f"{figures['ratio']:.5f}", percent(SIGMAS * figures["sigma"] / figures["mean"])]
    else:
        row += ["black", "-"]
    if figures["worst"]:
        (at_row, at_column), d, c, e = figures["worst"]
        row += [f"{at_row}, {at_column}", percent(d / c), percent(SIGMAS * e / c)]
    else:
        row += ["-", "-", "-"]
    return row + [f"{seconds:.0f}", verdict]


def picture(path, ours, theirs, outside):
    """Ours, Cycles', five times the difference on grey, and in white what is outside."""
    exposure = .8 / max(float(np.percentile(theirs, 97)), 1e-6)
    images = [ours * exposure, theirs * exposure, .2 + 5 * exposure * (ours - theirs), outside * 1.0]
    write_png(path, side_by_side([magnify(i, 4) for i in images]))


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("names", nargs="*", metavar="NAME")
    p.add_argument("--spp", type=int, default=1024)
    p.add_argument("--seed", type=int, default=0)
    p.add_argument("-o", "--out", help="the table as TSV")
    p.add_argument("--page", help="a page with the marker \"off\" for the table")
    p.add_argument("--pictures", help="a folder for a PNG of each scene")
    a = p.parse_args()
    rows, notes, failed = [], [], []
    print("\t".join(COLUMNS))
    for name in a.names or names_of_all():
        reference = Picture(os.path.join(BEAUTIES, name + ".exr"))
        theirs, theirs_error = reference.layer(), reference.layer("se")
        spp = max(int(a.spp * FACTOR.get(name, 1)), 16)
        try:
            ours, ours_error, report = render_off(scene_file(name), theirs.shape[:2], spp, a.seed)
        except RuntimeError as error:
            print(f"{name}: not run: {error}")
            if "not yet supported" not in str(error):
                failed.append(name)
            continue
        figures = compare(ours, ours_error, theirs, theirs_error)
        verdict = "pass" if figures["pass"] else "differs, known" if name in KNOWN else "FAIL"
        if verdict == "FAIL":
            failed.append(name)
        rows.append(row_of(name, spp, figures, report["cpu_s"], verdict))
        print("\t".join(str(x) for x in rows[-1]), flush=True)
        if name in KNOWN:
            notes.append(f"* {name}: {KNOWN[name]}.\n")
        if a.pictures:
            picture(os.path.join(a.pictures, name + ".png"), ours, theirs, figures["map"])
    print("\nKnown differences\n" + "".join(notes) + (f"\nfailed: {' '.join(failed)}" if failed else "\nall pass"))
    if a.out:
        write_table(a.out, COLUMNS, rows)
    if a.page:
        put_into_page(a.page, "off", markdown(COLUMNS, rows))
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
