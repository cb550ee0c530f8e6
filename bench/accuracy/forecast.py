# SPDX-License-Identifier: Apache-2.0
"""Does the progress line's forecast hold? Every bundled scene is rendered to a stated error; what was left of the time
by the progress lines, against what was left in the end.

usage: forecast.py PROGRAM SCENES_FOLDER [SCENE...]

Per scene a pilot of three seconds, or of more until it can, tells its error, and the render goes on to .6 and .35 of it, by the plan and by P
alone. Forecasts are read after every tenth of the render's own time. One thread; seconds are wall seconds, as the
forecast's are, so the machine should be idle or evenly busy."""
import bisect
import json
import os
import subprocess
import sys
import tempfile

SIZE, PILOT_S, PARTS, SHARES, FACTOR, LIMIT_S = "160x90", 3, [i / 10 for i in range(1, 10)], (0.6, 0.35), 1.5, 120


def render(program, scene, folder, *words):
    """The lines of progress while it rendered."""
    command = [program, scene, "-o", os.path.join(folder, "out.exr"), "--resolution", SIZE, "--threads", "1", "--progress", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    lines = [json.loads(line) for line in done.stderr.splitlines() if line.startswith("{")]
    return [x for x in lines if x["stage"] in ("rendering", "done")]


def left(lines):
    """[(forecast, actual) or None] seconds at PARTS of the time from the first line of rendering to the last."""
    begin, end = lines[0]["elapsed_s"], lines[-1]["elapsed_s"]
    told = [x for x in lines[:-1] if x["remaining_s"] is not None]
    times = [x["elapsed_s"] for x in told]
    out = []
    for part in PARTS:
        i = bisect.bisect(times, begin + part * (end - begin)) - 1
        out.append((told[i]["remaining_s"], end - told[i]["elapsed_s"]) if i >= 0 else None)
    return out


def main():
    program, folder, *names = sys.argv[1:]
    names = names or sorted(f[:-5] for f in os.listdir(folder) if f.endswith(".json"))
    good = [[] for _ in PARTS]
    print("| scene | estimator | to a stated error of | s | forecast over actual seconds left at "
          + ", ".join(f"{100 * p:.0f}" for p in PARTS) + " % |\n|---|---|---|---|---|", flush=True)
    with tempfile.TemporaryDirectory() as place:
        for name in names:
            scene = os.path.join(folder, name + ".json")
            for estimator in ("auto", "P"):
                words = ("--estimator", estimator)
                start, pilot_s = [{"error": None}], PILOT_S
                while start[-1]["error"] is None:  # of large scenes it has too few passes
                    start = render(program, scene, place, *words, "--time", str(pilot_s))
                    pilot_s *= 3
                for share in SHARES:
                    goal = share * start[-1]["error"]
                    lines = render(program, scene, place, *words, "--error", f"{goal:.4g}", "--time", str(LIMIT_S))
                    if lines[-1]["error"] > 1.02 * goal:
                        print(f"| {name} | {estimator} | {100 * goal:.2g} % | not in {LIMIT_S} | |", flush=True)
                        continue
                    found = left(lines)
                    ratios = [f[0] / max(f[1], 1e-3) if f else None for f in found]
                    for g, r in zip(good, ratios):
                        g.append(r is not None and 1 / FACTOR <= r <= FACTOR)
                    print(f"| {name} | {estimator} | {100 * goal:.2g} % | {lines[-1]['elapsed_s']:.1f} | "
                          + ", ".join("-" if r is None else f"{r:.2f}" for r in ratios) + " |", flush=True)
    shares = [100 * sum(g) / max(len(g), 1) for g in good]
    print(f"\nWithin a factor {FACTOR}: " + ", ".join(f"{s:.0f} % at {100 * p:.0f} %" for s, p in zip(shares, PARTS))
          + f" of {len(good[0])} renders; {sum(map(sum, good)) / max(sum(map(len, good)), 1):.0%} of all.")


main()
