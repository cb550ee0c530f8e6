# SPDX-License-Identifier: Apache-2.0
"""Exact answers: W, P and R against closed forms, one table. Arguments: effort (1: the quick test), names of cases;
--off X makes every truth wrong by that share, to show that the test can fail.

Exit 1 when an estimator misses a truth by more than the 99.9 % interval of its own seeds plus the bias stated for P."""
import sys

import cases
from rig import Check


def show(rows, check, off, effort):
    for case, quantity, exact, figures, bias in rows:
        for estimator, figure in figures.items():
            wanted, allowed = exact * off, effort.coarse(exact) if estimator == "W" else bias.get(estimator, 0)
            ok = figure.agrees(wanted, allowed)
            # A wide interval proves nothing.
            wide = figure.half_width() > max(0.05 * abs(exact), allowed)
            name = f"{case}: {quantity}"
            print(f"{name:74.74} {wanted:9.5f} {estimator} {figure.mean:9.5f} {figure.mean - wanted:+9.5f}"
                  f" +-{figure.half_width():8.5f} {allowed:8.5f} {'WRONG' if not ok else 'TOO WIDE' if wide else 'ok'}",
                  flush=True)
            if not ok or wide:
                check.failures.append(f"{name}, {estimator}")


def main(words):
    off = 1.0
    if "--off" in words:
        at = words.index("--off")
        off, words = 1 + float(words[at + 1]), words[:at] + words[at + 2:]
    effort = cases.Effort(float(words[0]) if words else 1.0)
    check = Check()
    print(f"{'case: quantity':74} {'truth':>9} E {'found':>9} {'error':>9}   {'95 %':>8} {'bias ok':>8}")
    for case in cases.CASES:
        if not words[1:] or case.__name__ in words[1:]:
            show(case(effort), check, off, effort)
    check.end()


if __name__ == "__main__":
    main(sys.argv[1:])
