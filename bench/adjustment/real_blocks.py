#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Rows of the table of bench/adjustment on photographs: what is predicted of control and of check points against what they
differ by, and blunders that are known to be in a block.

usage: bench/adjustment/real_blocks.py [--data FOLDER] [--collinea PROGRAM] [--work FOLDER] [--rows]

Blocks are oriented in the work folder (build/bench-adjustment); those found there are used again. sheffield_cross: five
control points from a handheld survey. odm_copr: a mark of gcp04 is wrong. demo: simulated photographs, the truth is
known. Blocks that are not in the data folder are skipped.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
STEPS = ["detect", "match", "orient"]


def row(what, must, measured, ok):
    print(f"| {what} | {must} | {measured} | {'yes' if ok else 'NO'} |", flush=True)
    return not ok


def run(program, *words):
    done = subprocess.run([str(program), *map(str, words), "--progress", "lines"], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"collinea {' '.join(map(str, words))}: {done.stderr}")
    return done.stderr


def oriented(program, project, photos, *options):
    if not (project / "oriented").exists():
        run(program, "import", photos, "-o", project, *options)
        for step in STEPS:
            run(program, step, project)
        (project / "oriented").touch()
    return project


def adjusted(program, project, *options):
    said = run(program, "adjust", project, *options)
    return json.loads((project / "adjustment/adjustment.json").read_text()), said


def squares(points, difference, sigma):
    """(sum of squared normalised differences, their number, root mean squares of differences and of sigmas)."""
    pairs = [(d, s) for point in points for d, s in zip(point[difference], point[sigma])
             if d is not None and s is not None and s > 0]
    n = max(1, len(pairs))
    return (sum((d / s) ** 2 for d, s in pairs), len(pairs), math.sqrt(sum(d * d for d, _ in pairs) / n),
            math.sqrt(sum(s * s for _, s in pairs) / n))


def of_chance(n, deviations):
    """Chi-squared of n degrees of freedom at that many standard deviations of a normal variable (Wilson, Hilferty 1931):
    n +- deviations sqrt(2 n) would let pass any sigma, however large, of fewer than 32 coordinates."""
    return n * max(0, 1 - 2 / (9 * n) + deviations * math.sqrt(2 / (9 * n))) ** 3


def predicted(what, points):
    """Differences are as long as predicted, no longer and no shorter than chance explains."""
    chi2, n, real, expected = squares(points, "difference_m", "sigma_m")
    low, high = (of_chance(n, -4), of_chance(n, 4)) if n else (0, 0)
    return row(what, "chi-squared of the differences within 4 deviations, as of a normal variable, on both sides",
               f"{len(points)} points: real {real:.4f} m, predicted {expected:.4f} m (root mean squares of coordinates); "
               f"chi-squared {chi2:.1f} of {n} ({low:.1f} to {high:.1f})", n > 0 and low <= chi2 <= high)


def leave_one_out(name, report):
    tests = report["reliability"]
    failed = predicted(f"leave-one-out of control, {name}", tests["left_out"])
    if tests["left_out_in_parts"]["points"]:
        failed += predicted(f"control left out in {tests['left_out_in_parts']['parts']} parts, {name}",
                           tests["left_out_in_parts"]["points"])
    return failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=ROOT.parent / "shared/data")
    parser.add_argument("--collinea", default=ROOT / "build/release/bin/collinea")
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build/bench-adjustment")
    parser.add_argument("--rows", action="store_true", help="print rows alone, without a head")
    asked = parser.parse_args()
    asked.work.mkdir(parents=True, exist_ok=True)
    if not asked.rows:
        print("| what | must show | measured | ok |\n|---|---|---|---|")
    failed = 0
    demo = asked.work / "demo"
    if not (demo / "block/control.csv").exists():
        run(asked.collinea, "simulate", demo / "block")
    project = oriented(asked.collinea, demo / "project", demo / "block/images", "--control", demo / "block/control.csv")
    report, _ = adjusted(asked.collinea, project)
    failed += leave_one_out("demo", report)
    failed += predicted("check points, demo", [p for p in report["control_points"] if p["role"] == "check"])
    for name in ("sheffield_cross", "odm_copr"):
        if not (asked.data / name).exists():
            failed += row(name, "the data", f"skipped: no {asked.data / name}", False)
    if (asked.data / "sheffield_cross").exists():
        block = asked.data / "sheffield_cross"
        project = oriented(asked.collinea, asked.work / block.name, block / "images", "--control", block / "gcp_list.txt")
        report, _ = adjusted(asked.collinea, project)
        failed += leave_one_out("sheffield_cross", report)
    if (asked.data / "odm_copr").exists():
        block = asked.data / "odm_copr"
        project = oriented(asked.collinea, asked.work / block.name, block / "images", "--control", block / "gcp_list.txt")
        _, said = adjusted(asked.collinea, project, "--snoop")
        first = next((line for line in said.split("\n") if "rejected: " in line), "nothing was rejected")
        failed += row("the wrong mark of odm_copr", "gcp04 in IMG_0031 named first", first.split("note: ")[-1],
                      "gcp04 in IMG_0031" in first)
    return failed


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
