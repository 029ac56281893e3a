#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Time and memory of orientation against the number of images, on simulated blocks without photographs.

usage: bench/scale.py [--images N,N,...] [--mode auto|incremental|global] [--out DIR] [--collinea PROGRAM]
  --images    sizes (default 500,1000,2000,4000)
  --mode      how the block begins (default auto)
  --out       where the projects and plot.svg go (default build/bench-scale); blocks simulated there are used again
Prints a table, and the exponent of time and memory against size by least squares in logarithms. Times are those that the step records: of the processor,
all threads, and by the clock.
"""
import argparse
import json
import math
import os
import re
import shutil
import subprocess
import sys

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
    x, y = [math.log(v) for v in sizes], [math.log(v) for v in values]
    mx, my = sum(x) / len(x), sum(y) / len(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def plot(sizes, cpu_s, memory_gib):
    """plot.svg: both against size, logarithmic, each over its first value; dotted: in proportion to size."""
    width, height, edge = 480, 360, 50
    decades = math.log10(sizes[-1] / sizes[0]) * 1.3

    def at(size, ratio):
        x = edge + (width - 2 * edge) * math.log10(size / sizes[0]) / math.log10(sizes[-1] / sizes[0])
        return f"{x:.1f},{height - edge - (height - 2 * edge) * math.log10(ratio) / decades:.1f}"

    def line(values, style):
        points = " ".join(at(s, v / values[0]) for s, v in zip(sizes, values))
        return f'<polyline points="{points}" fill="none" stroke-width="2" {style}/>'

    text = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
            'font-size="12">', '<rect width="100%" height="100%" fill="white"/>',
            line(sizes, 'stroke="grey" stroke-dasharray="2 4"'), line(cpu_s, 'stroke="#1060a0"'),
            line(memory_gib, 'stroke="#c04020"')]
    for size, seconds, gib in zip(sizes, cpu_s, memory_gib):
        x = at(size, 1).split(",")[0]
        text.append(f'<text x="{x}" y="{height - edge + 18}" text-anchor="middle">{size}</text>')
        text.append(f'<text x="{x}" y="{height - edge + 32}" text-anchor="middle" fill="#1060a0">{seconds:.1f} s</text>')
        text.append(f'<text x="{x}" y="{height - edge + 46}" text-anchor="middle" fill="#c04020">{gib:.2f} GiB</text>')
    text.append(f'<text x="{edge}" y="25">images against processor time (blue) and memory (red); dotted: proportional</text>')
    with open(os.path.join(args.out, "plot.svg"), "w") as file:
        file.write("\n".join(text + ["</svg>", ""]))


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
