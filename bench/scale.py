#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Time and memory of orientation against the number of images, on simulated blocks without photographs.

usage: bench/scale.py [--images N,N,...] [--mode auto|incremental|global] [--out DIR] [--collinea PROGRAM]
  --images    sizes (default 500,1000,2000,4000)
  --mode      how the block begins (default auto)
  --out       where the projects and plot.svg go (default build/bench-scale); blocks simulated there are used again
Prints a table, and the exponent of time and memory against size by least squares in logarithms. Needs python3-numpy;
the plot needs python3-matplotlib and is left out without it. Times are those that the step records: of the processor,
all threads, and by the clock.
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys

import numpy as np

root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
parser = argparse.ArgumentParser()
parser.add_argument("--images", default="500,1000,2000,4000")
parser.add_argument("--mode", default="auto")
parser.add_argument("--out", default=os.path.join(root, "build", "bench-scale"))
parser.add_argument("--collinea", default=os.path.join(root, "build", "release", "bin", "collinea"))
args = parser.parse_args()


def collinea(*words):
    done = subprocess.run([args.collinea, *map(str, words)], stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"FAILED ({done.returncode}): collinea {' '.join(map(str, words))}")
    return done.stdout


def simulated(images):
    """A project with features and pairs; GPS, no control."""
    block = os.path.join(args.out, f"block-{images}")
    if not os.path.exists(os.path.join(block, "truth", "frame.csv")):
        collinea("simulate", block, "--images", images, "--control-points", 0, "--observations-only", "--progress", "none")
    return block


def oriented(images):
    block, project = simulated(images), os.path.join(args.out, f"project-{images}-{args.mode}")
    shutil.rmtree(project, ignore_errors=True)
    shutil.copytree(block, project)
    collinea("orient", project, "--mode", args.mode, "--progress", "none")
    info = json.loads(collinea("info", project, "--json"))
    step = next(s for s in info["steps"] if s["name"] == "orient")
    assessed = collinea("assess", project, os.path.join(block, "truth"))
    centres = [re.search(rf"{what} +\d+ .*3D ([\d.]+) m +worst ([\d.]+)", assessed)
               for what in ("projection centres", "projection centres, aligned")]
    return info, step, [tuple(map(float, m.groups())) for m in centres]


def exponent(sizes, values):
    return np.polyfit(np.log(sizes), np.log(values), 1)[0]


def plot(sizes, cpu_s, memory_gib):
    try:
        import matplotlib
        matplotlib.use("svg")
        from matplotlib import pyplot
    except ImportError:
        return print("no plot: python3-matplotlib is not there")
    figure, left = pyplot.subplots(figsize=(6, 4))
    left.loglog(sizes, cpu_s, "o-", label="processor time [s]")
    left.loglog(sizes, cpu_s[0] * np.array(sizes) / sizes[0], ":", color="grey", label="proportional to size")
    left.set_xlabel("images")
    left.set_ylabel("s")
    right = left.twinx()
    right.loglog(sizes, memory_gib, "s--", color="tab:red", label="peak memory [GiB]")
    right.set_ylabel("GiB")
    figure.legend(loc="upper left", bbox_to_anchor=(0.13, 0.87))
    figure.savefig(os.path.join(args.out, "plot.svg"))


os.makedirs(args.out, exist_ok=True)
sizes, cpu_s, memory_gib = [], [], []
print("| images | oriented | CPU s | s | peak GiB | centres RMS m | worst m | aligned RMS m |")
print("|---|---|---|---|---|---|---|---|", flush=True)
for size in map(int, args.images.split(",")):
    info, step, ((rms, worst), (aligned, _)) = oriented(size)
    sizes.append(size)
    cpu_s.append(step["cpu_seconds"])
    memory_gib.append(step["peak_memory_bytes"] / 2**30)
    print(f"| {size} | {info['oriented']} | {cpu_s[-1]:.1f} | {step['seconds']:.1f} | {memory_gib[-1]:.2f} | {rms:.3f} | "
          f"{worst:.3f} | {aligned:.3f} |", flush=True)
if len(sizes) > 1:
    print(f"exponent of processor time {exponent(sizes, cpu_s):.2f}, of memory {exponent(sizes, memory_gib):.2f}")
    plot(sizes, cpu_s, memory_gib)
