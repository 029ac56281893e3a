#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What dense matching, surface and orthophoto must show, and what they do, as one table.

usage: bench/dense/table.py [--only stereo,beach,demo,exposures,memory] [--data DIR] [--out DIR] [--bin DIR]
  --only  rows; default: all but memory (which renders 450 images, and takes 10 minutes of processor time)
  --data  folder of the real blocks (default ../shared/data); what is not there is skipped, saying so
  --out   where the projects go (default build/bench-dense); projects found there are continued
  --bin   folder of the programs (default build/release/bin)
beach needs python3-pil: the pictures are reduced to 1000 px width first. Exit code 1 when anything falls short or dies.
"""
import argparse
import json
import math
import os
import re
import resource
import signal
import sqlite3
import struct
import subprocess
import sys

root = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
parser = argparse.ArgumentParser()
parser.add_argument("--only", default="stereo,beach,demo,exposures")
parser.add_argument("--data", default=os.path.join(os.path.dirname(root), "shared", "data"))
parser.add_argument("--out", default=os.path.join(root, "build", "bench-dense"))
parser.add_argument("--bin", default=os.path.join(root, "build", "release", "bin"))
args = parser.parse_args()


class Died(Exception):
    pass


short = []  # what is not as wanted


def row(what, wanted, measured, ok=None):
    """ok: None where nothing is wanted, or where it could not be measured."""
    if ok is False:
        short.append(what)
    print(f"| {what} | {wanted} | {measured} | {'-' if ok is None else 'ok' if ok else 'SHORT'} |", flush=True)


def run(*words):
    """(stdout, CPU seconds) of a program; what it says on stderr goes to ours."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run([str(w) for w in words], stdout=subprocess.PIPE, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        how = signal.Signals(-done.returncode).name if done.returncode < 0 else f"exit code {done.returncode}"
        raise Died(f"{how}: {' '.join(map(str, words))}")
    return done.stdout, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def collinea(*words):
    return run(os.path.join(args.bin, "collinea"), *words)


def info(project):
    return json.loads(collinea("info", project, "--json")[0])


def stereo():
    program = os.path.join(args.bin, "collinea_bench_stereo")
    if not os.path.exists(program):
        return print("stereo: skipped, no " + program)
    wanted = {"cones": 3.0, "cloth3": 0.8, "wood2": 1.8}
    for threads in (1, 2):
        text, _ = run(program, "--middlebury", os.path.join(args.data, "middlebury_stereo"), "--threads", threads)
        rows, faster = {}, {}
        for line in text.splitlines():
            cells = [c.strip() for c in line.strip("|").split("|")]
            if len(cells) == 9 and cells[1] in ("collinea", "OpenCV SGBM HH"):
                rows.setdefault(cells[0], {})[cells[1]], name = cells, cells[0]
            if found := re.match(r"times as fast: ([\d.]+) in processor time, ([\d.]+)", line):
                faster[name] = found
        for name, by in rows.items():
            ours, theirs = by["collinea"], by["OpenCV SGBM HH"]
            if threads == 1:
                row(f"{name}: bad-2px of measured, left out; filled", f"<= {wanted[name]} %" if name in wanted else "-",
                    f"{ours[2]} %, {ours[3]} %; {ours[4]} % (SGBM {theirs[2]} %, {theirs[3]} %; {theirs[4]} %)",
                    float(ours[2]) <= wanted[name] if name in wanted else None)
            row(f"{name}: two-view speed, {threads} thread{'s' if threads > 1 else ''}", ">= 3 x SGBM MODE_HH",
                f"{faster[name][2]} x on the clock ({ours[8]} s), {faster[name][1]} x in processor time",
                float(faster[name][2]) >= 3)
        for name in wanted.keys() - rows.keys():
            row(f"{name}: two views, {threads} thread{'s' if threads > 1 else ''}", "a figure", "none", False)


def beach():
    photos = os.path.join(args.data, "brighton_beach", "images")
    if not os.path.isdir(photos):
        return print("brighton_beach: skipped, no " + photos)
    from PIL import Image

    out = os.path.join(args.out, "beach")
    small = os.path.join(out, "images")
    os.makedirs(small, exist_ok=True)
    for name in sorted(os.listdir(photos)):
        with Image.open(os.path.join(photos, name)) as picture:
            size = (1000, round(1000 * picture.height / picture.width))
            picture.resize(size, Image.LANCZOS).save(os.path.join(small, name), quality=92, exif=picture.info.get("exif", b""))
    project = os.path.join(out, "project")
    collinea("run", small, "-o", project, "--until", "orient")
    _, cpu = collinea("densify", project, "--resolution", "full")
    i = info(project)
    with open(os.path.join(project, "products", "cloud.las"), "rb") as cloud:
        points = struct.unpack_from("<Q", cloud.read(375), 247)[0]
    row("brighton_beach at 1000 px: 18 depth maps, fused", "<= 50 CPU s (OpenMVS 2.3: 496), all images",
        f"{cpu:.1f} CPU s, {points} points, {i.get('oriented')} of {i.get('images')} images",
        cpu <= 50 and i.get("oriented") == i.get("images"))


# Rows of `collinea assess`: how they begin, what is wanted, where the figures are, and whether these are good enough.
DEMO = [
    ("surface model, smooth ground", "RMSE <= 0.7 GSD", r"RMSE .*?= ([\d.]+) GSD", lambda gsd: gsd <= 0.7),
    ("surface model, roofs", "RMSE <= 1.0 GSD", r"RMSE .*?= ([\d.]+) GSD", lambda gsd: gsd <= 1.0),
    ("surface model, walls", "RMS <= 2 GSD", r"RMS .*?= ([\d.]+) GSD", lambda gsd: gsd <= 2),
    ("surface model, completeness", ">= 98 % where three images see", r"images see ([\d.]+) %", lambda part: part >= 98),
    ("surface model, sigma", "90-98 % within 95 % bounds", r"bounds ([\d.]+) %", lambda part: 90 <= part <= 98),
    ("terrain model, all", "RMSE <= 1 GSD", r"RMSE .*?= ([\d.]+) GSD", lambda gsd: gsd <= 1),
    ("terrain model, objects removed", ">= 95 %", r"([\d.]+) % of", lambda part: part >= 95),
    ("orthophoto, local shift", "<= 0.5 px RMS", r"RMS x ([\d.]+)  y ([\d.]+) px", lambda x, y: math.hypot(x, y) <= 0.5),
    ("orthophoto, colours", "<= 0.5 % wrong surface", r"wrong surface ([\d.]+) %", lambda part: part <= 0.5),
]


def judge_lines(of, rows, lines):
    for start, wanted, pattern, good in rows:
        line = next((l for l in lines if l.startswith(start)), "")
        found = re.search(pattern, line)
        row(of + start, wanted, re.sub(r"  +", " ", line[len(start):].strip()) if found else "no such row of collinea assess",
            bool(found) and good(*map(float, found.groups())))


def demo():
    block, project = (os.path.join(args.out, "accuracy", "demo", f) for f in ("block", "project"))  # of bench/accuracy.py, too
    if not os.path.exists(os.path.join(block, "truth", "dtm.tif")):
        collinea("simulate", block)
    collinea("run", os.path.join(block, "images"), "-o", project, "--control", os.path.join(block, "control.csv"))
    lines = collinea("assess", project, os.path.join(block, "truth"))[0].splitlines()
    judge_lines("demo: ", DEMO, lines)


# Exposures of +-30 % at two thirds of the photographs and more at the others, white balance of +-5 %, corners at 60 %.
def exposures():
    out = os.path.join(args.out, "exposures")
    block, project = os.path.join(out, "block"), os.path.join(out, "project")
    if not os.path.exists(os.path.join(block, "truth", "dtm.tif")):
        collinea("simulate", block, "--exposure-sigma", 0.3, "--white-balance-sigma", 0.05, "--vignetting", 0.4)
    collinea("run", os.path.join(block, "images"), "-o", project, "--control", os.path.join(block, "control.csv"),
             "--until", "ortho")
    lines = collinea("assess", project, os.path.join(block, "truth"))[0].splitlines()
    judge_lines("demo with planted exposures: ", [what for what in DEMO if what[0].startswith("orthophoto")], lines)
    with sqlite3.connect(os.path.join(project, "block.db")) as store:
        made = json.loads(store.execute("SELECT report_json FROM steps WHERE name = 'ortho'").fetchone()[0])
    row("demo with planted exposures: seams", "step <= 1 grey of 255",
        f"{made['seam_length_m']:.0f} m, step {made['seam_step_grey']:.2f} grey, pictures differ by "
        f"{made['seam_difference_grey']:.1f} grey", made["seam_step_grey"] <= 1)


def memory():
    """All to the scale of pictures a tenth as large as usual: caches, which 50 fill, and the features that make tie points."""
    peaks = []
    for images in (50, 400):
        out = os.path.join(args.out, f"memory-{images}")
        block, project = os.path.join(out, "block"), os.path.join(out, "project")
        if not os.path.isdir(os.path.join(block, "truth")):
            collinea("simulate", block, "--images", images, "--width-px", 600, "--height-px", 450, "--gsd-m", 0.13)
        collinea("run", os.path.join(block, "images"), "-o", project, "--max-features", 750, "--until", "orient")
        collinea("densify", project, "--memory-mb", 20)
        steps = {s["name"]: s for s in info(project)["steps"]}
        peaks.append(steps["densify"]["peak_memory_bytes"] / 2**20)
    more = peaks[1] / peaks[0] - 1
    row("memory of densify, 50 and 400 images", "same within 10 %, <= 4 GiB",
        f"{peaks[0]:.0f} and {peaks[1]:.0f} MiB ({100 * more:+.0f} %)", abs(more) <= 0.1 and max(peaks) <= 4096)


os.makedirs(args.out, exist_ok=True)
row_names = {"stereo": stereo, "beach": beach, "demo": demo, "exposures": exposures, "memory": memory}
if unknown := set(args.only.split(",")) - set(row_names):
    parser.error(f"no such row: {', '.join(sorted(unknown))}")
print("| what | must show | measured | verdict |\n| --- | --- | --- | --- |", flush=True)
for name in args.only.split(","):
    try:
        row_names[name]()
    except Died as death:
        row(name, "an end", f"DIED with {death}", False)
if short:
    sys.exit("SHORT: " + "; ".join(short))
