#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Matchers of a rectified pair beside true disparities: semi-global matching, each local cost and the levels, as one table.

usage: bench/dense/rectified.py [--only cones,cloth3,wood2] [--data DIR] [--bin DIR] [--out DIR] [--window PX,PX,...]
  --data    folder of cones, cloth3 and wood2 (default ../shared/data/middlebury_stereo); what is not there is skipped, saying so
  --bin     folder of the program (default build/release/bin)
  --out     where results go (default build/bench-rectified)
  --window  sides of the windows of local costs (default 9)
Needs python3-numpy and python3-pil. Each matcher runs twice by `collinea stereo --rectified`, on one thread: as it is, and with
--fill. Pixels count where the left image's disparity is known. Seen by both: where the right image's true disparity, at the place that
the left one's says, is the same within 1 px; what the right image does not show, or has no truth for, is not.
  > 1, > 2     further off than so many px, of the pixels that were measured [%]; of those seen by both, and of all
  measured     of the pixels seen by both, and of all [%]
  mean         of the errors of up to 1 px, without their sign, of all [px]
  in bounds    of these, errors within 1.96 sigma [%]
  filled > 2   holes filled: further off than 2 px or still empty, of all [%]
  CPU s        of the command without --fill, which reads and writes images, too: the least of three rounds
"""
import argparse
import os
import resource
import subprocess
import sys

import numpy
from PIL import Image

root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
parser = argparse.ArgumentParser()
parser.add_argument("--only", default="cones,cloth3,wood2")
parser.add_argument("--data", default=os.path.join(os.path.dirname(root), "shared", "data", "middlebury_stereo"))
parser.add_argument("--bin", default=os.path.join(root, "build", "release", "bin"))
parser.add_argument("--out", default=os.path.join(root, "build", "bench-rectified"))
parser.add_argument("--window", default="9")
parser.add_argument("--rounds", type=int, default=3)
args = parser.parse_args()

FACTORS = {"cones": 4, "cloth3": 2, "wood2": 2}  # of the files of true disparities


def matchers():
    for cost in ("census", "zncc", "rank", "sad", "ssd"):
        yield f"dense {cost}", ["--matcher", "dense", "--cost", cost]
    for cost in ("ncc", "ssd", "sad", "rank", "census", "d", "dn"):
        for window in args.window.split(","):
            name = f"local {cost}" + (f", {window} px" if "," in args.window else "")
            yield name, ["--matcher", "local", "--local-cost", cost, "--local-window-px", window]
    yield "levels", ["--matcher", "levels"]
    yield "levels, grid 4 px", ["--matcher", "levels", "--grid-px", "4"]
    yield "levels, grid 1 px", ["--matcher", "levels", "--grid-px", "1"]


def truth_of(folder, factor):
    """Disparities of the left image, NaN where unknown, and where the right image shows the same."""
    def read(side):
        values = numpy.asarray(Image.open(os.path.join(folder, f"disp_{side}_x{factor}.png"))).astype(float)
        return numpy.where(values > 0, values / factor, numpy.nan)

    left, right = read("left"), read("right")
    columns = numpy.arange(left.shape[1])[None, :] - left
    inside = numpy.isfinite(columns) & (columns >= -0.5) & (columns < right.shape[1] - 0.5)
    there = numpy.rint(numpy.where(inside, columns, 0)).astype(int)
    shown = right[numpy.arange(left.shape[0])[:, None], there]
    with numpy.errstate(invalid="ignore"):
        return left, inside & (abs(shown - left) <= 1)


def grey_of(folder, truth, both):
    """How far grey values of true matches differ, and how far those of a window of 9 x 9 do (median): standard deviations."""
    left, right = (numpy.asarray(Image.open(os.path.join(folder, side + ".png")).convert("L")).astype(float) for side in ("left", "right"))
    rows, columns = numpy.nonzero(both)
    difference = left[rows, columns] - right[rows, numpy.rint(columns - truth[rows, columns]).astype(int)]

    def mean(values, side=9):
        sums = numpy.pad(values, ((1, 0), (1, 0))).cumsum(0).cumsum(1)
        return (sums[side:, side:] - sums[:-side, side:] - sums[side:, :-side] + sums[:-side, :-side]) / side**2

    texture = numpy.sqrt(numpy.maximum(mean(left**2) - mean(left) ** 2, 0))
    return difference.std(), numpy.median(texture)


def range_of(folder):
    with open(os.path.join(folder, "drange.txt")) as file:
        values = dict(word.split("=") for word in file.read().split())
    return int(values["dmin"]), int(values["dmax"]) - 1


def match(folder, out, more):
    """Disparities, sigmas, CPU seconds."""
    low, high = range_of(folder)
    command = [os.path.join(args.bin, "collinea"), "stereo", os.path.join(folder, "left.png"), os.path.join(folder, "right.png"),
               "--rectified", "--min-disparity", str(low), "--max-disparity", str(high), "--threads", "1", "-o", out, *more]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(" ".join(command) + "\n" + done.stdout)
    read = [numpy.asarray(Image.open(os.path.join(out, name))).astype(float) for name in ("disparity.tif", "sigma.tif")]
    return *read, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def percent(part, whole):
    return f"{100 * part / whole:.1f}" if whole else "-"


def judge(pair, name, folder, truth, both, more):
    out = os.path.join(args.out, pair, name.replace(" ", "_").replace(",", ""))
    rounds = [match(folder, out, more) for _ in range(args.rounds)]
    found, sigma, _ = rounds[0]
    filled = match(folder, out, [*more, "--fill"])[0]
    known = numpy.isfinite(truth)
    measured = known & numpy.isfinite(found)
    off = numpy.where(measured, abs(found - truth), 0)
    cells = []
    for region in (both, known):
        here = measured & region
        cells += [percent((off[here] > 1).sum(), here.sum()), percent((off[here] > 2).sum(), here.sum()),
                  percent(here.sum(), region.sum())]
    good = measured & (off <= 1)
    bounded = good & numpy.isfinite(sigma)
    cells.append(f"{off[good].mean():.2f}")
    cells.append(percent((off[bounded] <= 1.96 * sigma[bounded]).sum(), bounded.sum()))
    cells.append(percent((known & ~(abs(filled - truth) <= 2)).sum(), known.sum()))
    cells.append(f"{min(seconds for *_, seconds in rounds):.2f}")
    print(f"| {pair} | {name} | " + " | ".join(cells) + " |", flush=True)


print("| pair | matcher | seen by both: > 1 px % | > 2 px % | measured % | all: > 1 px % | > 2 px % | measured % | mean px | in bounds % "
      "| filled > 2 px % | CPU s |")
print("|---|---|---|---|---|---|---|---|---|---|---|---|", flush=True)
for pair in args.only.split(","):
    folder = os.path.join(args.data, pair)
    if not os.path.isdir(folder):
        print(f"skipped: {pair}: no {folder}", file=sys.stderr)
        continue
    truth, both = truth_of(folder, FACTORS[pair])
    between, within = grey_of(folder, truth, both)
    print(f"{pair}: grey values of true matches differ by {between:.1f}, those of a window of the left image by {within:.1f}",
          file=sys.stderr)
    for name, more in matchers():
        judge(pair, name, folder, truth, both, more)
