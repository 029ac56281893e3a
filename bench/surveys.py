#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Do check points lie within the regions that the main job predicts? Many simulated surveys, from features to the adjustment.

usage: bench/surveys.py [--surveys N] [--out DIR] [--collinea PROGRAM] [--points-per-image N] [-- OPTION ...]
Each survey: a made-up world, cameras known as headers tell them, GNSS of metres, six control and twelve check points; features and
matches with noise and mismatches, but no photographs (`collinea simulate --observations-only`). It is oriented and adjusted by
`collinea adjust PROJECT OPTION ...`, as `run` does it. For each check point d' C^-1 d of its difference with the covariance that
the adjustment predicts of it (block and survey) is compared with the chi-squared distribution, also in plan and height apart.
Prints the shares within regions of 50, 95 and 99 %, and the mean over its expectation; ends with 1 where the share in 95 % regions
is not within 93 and 97 %.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys

import numpy as np

parser = argparse.ArgumentParser()
root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
parser.add_argument("--surveys", type=int, default=200)
parser.add_argument("--out", default=os.path.join(root, "build", "bench-surveys"))
parser.add_argument("--collinea", default=os.path.join(root, "build", "release", "bin", "collinea"))
parser.add_argument("--points-per-image", type=int, default=300)
parser.add_argument("options", nargs="*")
args = parser.parse_args()

# Quantiles of chi-squared at 50, 95, 99 % with one, two and three degrees of freedom.
QUANTILES = {1: (0.4549, 3.8415, 6.6349), 2: (1.3863, 5.9915, 9.2103), 3: (2.3660, 7.8147, 11.3449)}


def collinea(*words):
    done = subprocess.run([args.collinea, *map(str, words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    return done.returncode, done.stdout + done.stderr


def check_points(project):
    """Differences and their covariances [m, m^2]: of the block and of the survey."""
    with open(os.path.join(project, "adjustment", "adjustment.json")) as file:
        adjustment = json.load(file)
    for point in adjustment["control_points"]:
        if point["role"] == "check" and point["covariance_m2"]:
            of_block = np.array(point["covariance_m2"])
            survey = np.square(point["sigma_m"]) - np.diag(of_block)
            yield np.array(point["difference_m"]), of_block + np.diag(survey)


values = {1: [], 2: [], 3: []}
failed = 0
for seed in range(1, args.surveys + 1):
    project = os.path.join(args.out, "survey")
    shutil.rmtree(project, ignore_errors=True)
    code, text = collinea("simulate", project, "--observations-only", "--seed", seed, "--points-per-image",
                          args.points_per_image, "--progress", "none")
    if code == 0:
        code, text = collinea("adjust", project, "--progress", "none", *args.options)
    if code != 0:
        failed += 1
        print(f"survey {seed}: {text.strip().splitlines()[-1:]}", file=sys.stderr)
        continue
    for difference, covariance in check_points(project):
        for degrees, axes in ((1, [2]), (2, [0, 1]), (3, [0, 1, 2])):
            d, c = difference[axes], covariance[np.ix_(axes, axes)]
            values[degrees].append(float(d @ np.linalg.solve(c, d)))

print(f"{args.surveys} surveys, {failed} failed, {len(values[3])} check points")
print("| region | within 50 % | within 95 % | within 99 % | mean over expectation |\n| --- | --- | --- | --- | --- |")
for degrees, name in ((3, "position"), (2, "plan"), (1, "height")):
    v = np.array(values[degrees])
    shares = [100 * float(np.mean(v < limit)) for limit in QUANTILES[degrees]]
    print(f"| {name} | {shares[0]:.1f} % | {shares[1]:.1f} % | {shares[2]:.1f} % | {float(np.mean(v)) / degrees:.3f} |")
share = 100 * float(np.mean(np.array(values[3]) < QUANTILES[3][1]))
sys.exit(0 if 93 <= share <= 97 and failed == 0 else 1)
