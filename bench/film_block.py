#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Do check points of a block of film lie within what its adjustment predicts?

usage: bench/film_block.py --collinea PROGRAM --work DIR [--seeds N ...] [--scan-um UM] [--local-um UM] [--control N] [--check N]
                           [--threads N]
Renders 3 strips of 6 scans of film (`simulate --film`), maps them to the adjustment (`run --film`) with --control control points, and
prints for each seed the root mean square of the errors of check points (surveyed to 1 cm), what was predicted,
and the share of them whose error lies within the 95 % ellipsoid (chi-squared of three degrees of freedom, 7.815).
"""
import argparse
import json
import math
import pathlib
import shutil
import subprocess

PER_CENT_95 = 7.815


def solved(matrix, right):
    """x of matrix x = right, by Gauss's elimination."""
    rows = [row[:] + [value] for row, value in zip(matrix, right)]
    n = len(rows)
    for i in range(n):
        rows.insert(i, rows.pop(max(range(i, n), key=lambda r: abs(rows[r][i]))))
        for j in range(i + 1, n):
            factor = rows[j][i] / rows[i][i]
            rows[j] = [a - factor * b for a, b in zip(rows[j], rows[i])]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (rows[i][n] - sum(rows[i][k] * x[k] for k in range(i + 1, n))) / rows[i][i]
    return x


def one_seed(asked, seed):
    folder = pathlib.Path(asked.work) / f"seed_{seed}"
    block, project = folder / "block", folder / "project"
    shutil.rmtree(project if asked.keep else folder, ignore_errors=True)
    folder.mkdir(parents=True, exist_ok=True)

    def call(*words):
        done = subprocess.run([asked.collinea, *map(str, words), "--threads", str(asked.threads), "--progress", "none"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode:
            raise SystemExit(done.stdout[-2000:])
        return done.stdout

    if not (block / "control.csv").exists():
        call("simulate", block, "--film", "--scan-um", asked.scan_um, "--film-local-um", asked.local_um, "--seed", seed,
             "--control-points", asked.control, "--check-points", asked.check)
    call("run", block / "images", "-o", project, "--film", block / "film_calibration.txt", "--control", block / "control.csv", "--until",
         "adjust")
    marks = json.loads((project / "adjustment" / "adjustment.json").read_text())["control_points"]
    checks = [mark for mark in marks if mark["role"] == "check"]
    within, squares, variances, weighted = 0, [0.0] * 3, [0.0] * 3, [0.0] * 3
    for mark in checks:
        error, covariance = mark["difference_m"], mark["covariance_m2"]
        within += sum(e * s for e, s in zip(error, solved(covariance, error))) < PER_CENT_95
        for i in range(3):
            squares[i] += error[i] ** 2 / len(checks)
            variances[i] += covariance[i][i] / len(checks)
            weighted[i] += error[i] ** 2 / covariance[i][i] / len(checks)
    rejected = sum(1 for mark in marks if mark["role"] == "control" and None in mark["difference_m"])
    if not asked.keep:
        shutil.rmtree(folder, ignore_errors=True)
    return within, len(checks), squares, variances, weighted, rejected


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--collinea", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4])
    parser.add_argument("--scan-um", type=float, default=60)
    parser.add_argument("--local-um", type=float, default=4)
    parser.add_argument("--control", type=int, default=12)
    parser.add_argument("--check", type=int, default=100)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--keep", action="store_true", help="leave the scans, and take those that an earlier run left")
    asked = parser.parse_args()
    print("| seed | RMS E, N, H [m] | predicted [m] | squares of error over sigma | check points within 95 % | control rejected |")
    print("|---|---|---|---|---|---|")
    all_within = all_checks = 0
    for seed in asked.seeds:
        within, checks, squares, variances, weighted, rejected = one_seed(asked, seed)
        all_within += within
        all_checks += checks
        print("| {} | {} | {} | {} | {} of {} | {} |".format(
            seed, " ".join(f"{math.sqrt(s):.3f}" for s in squares), " ".join(f"{math.sqrt(v):.3f}" for v in variances),
            " ".join(f"{w:.2f}" for w in weighted), within, checks, rejected), flush=True)
    print(f"| all | | | | {all_within} of {all_checks} ({100 * all_within / all_checks:.1f} %) | |")


if __name__ == "__main__":
    main()
