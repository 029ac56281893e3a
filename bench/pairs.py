#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How many of the image pairs that matching all with all verifies does the default selection find, and at what cost?

usage: bench/pairs.py [--data DIR] [--out DIR] [--collinea PROGRAM] [--repeats N] [BLOCK...]
For each block (default: brighton_beach sheffield_cross oppaiyama) features are found once; then `--pairs all` and the
defaults are run on copies of that project, and the table says: images; pairs searched and verified by all; pairs
searched by auto; recall (the part of all's verified pairs that auto verifies too), also of the pairs with 30 matches
and more; CPU-seconds of the step (medians), their ratio; images oriented and tie points in both. --no-orient leaves
the last two out.
"""
import argparse
import json
import os
import shutil
import sqlite3
import statistics
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BLOCKS = ["brighton_beach", "sheffield_cross", "oppaiyama"]
MATCH_BYTES = 8


def run(args, block, project, until, *options):
    photos = os.path.join(args.data, block, "images")
    done = subprocess.run([args.collinea, "run", photos, "-o", project, "--until", until, "--progress", "none", *options],
                          stderr=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"{block}: collinea failed ({done.returncode}):\n{done.stderr}")


def step(args, project, name):
    info = json.loads(subprocess.check_output([args.collinea, "info", project, "--json"]))
    its = next(step for step in info["steps"] if step["name"] == name)
    return its["cpu_seconds"], its["figures"]


def verified_pairs(project):
    with sqlite3.connect(os.path.join(project, "block.db")) as store:
        rows = store.execute("SELECT first, second, length(matches) FROM pairs WHERE length(matches) > 0")
        return {(first, second): size // MATCH_BYTES for first, second, size in rows}


def measure(args, block, choice):
    """The project, the median CPU-seconds of matching, and the reports of matching and orientation."""
    start = os.path.join(args.out, block, "start")
    project = os.path.join(args.out, block, choice)
    costs = []
    for _ in range(args.repeats):
        shutil.rmtree(project, ignore_errors=True)
        shutil.copytree(start, project)
        run(args, block, project, "match", "--pairs", choice)
        costs.append(step(args, project, "match")[0])
    oriented = {}
    if args.orient:
        run(args, block, project, "orient", "--pairs", choice)
        oriented = step(args, project, "orient")[1]
    return project, statistics.median(costs), step(args, project, "match")[1], oriented


def row(args, block):
    start = os.path.join(args.out, block, "start")
    shutil.rmtree(start, ignore_errors=True)
    run(args, block, start, "detect")
    all_project, all_cost, all_report, all_oriented = measure(args, block, "all")
    project, cost, report, oriented = measure(args, block, "auto")
    truth, found = verified_pairs(all_project), verified_pairs(project)
    strong = {pair for pair, matches in truth.items() if matches >= 30}
    line = (f"| {block} | {all_report['pairs_searched']} | {len(truth)} | {report['pairs_searched']} | {len(found)} "
            f"| {len(truth.keys() & found.keys()) / len(truth):.3f} | {len(strong & found.keys()) / len(strong):.3f} "
            f"| {all_cost:.2f} | {cost:.2f} | {cost / all_cost:.2f} |")
    if args.orient:
        line += (f" {all_oriented['oriented']} / {oriented['oriented']} of {oriented['images']} "
                 f"| {all_oriented['tie_points']} / {oriented['tie_points']} |")
    return line


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("blocks", nargs="*", default=BLOCKS)
    parser.add_argument("--data", default=os.path.join(os.path.dirname(ROOT), "shared", "data"))
    parser.add_argument("--out", default=os.path.join(ROOT, "build", "bench-pairs"))
    parser.add_argument("--collinea", default=os.path.join(ROOT, "build", "release", "bin", "collinea"))
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--no-orient", dest="orient", action="store_false")
    args = parser.parse_args()
    more = " oriented, all / auto | tie points, all / auto |" if args.orient else ""
    print("| block | pairs searched by all | verified by all | searched by auto | verified by auto | recall | recall of "
          "30 matches and more | all [CPU-s] | auto [CPU-s] | ratio |" + more)
    print("|" + "---|" * (12 if args.orient else 10))
    for block in args.blocks:
        print(row(args, block), flush=True)


if __name__ == "__main__":
    main()
