#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Accuracy of the main job on blocks with known truth, as one table.

usage: bench/accuracy.py [--data DIR] [--out DIR] [--only NAME,...] [--collinea PROGRAM] [--killed]
  --data  folder of the real blocks (default ../shared/data); blocks that are not there are skipped, saying so
  --out   where the projects go (default build/bench-accuracy); rendered photographs found there are used again,
          projects are not: a step that another build of the same version has done counts as up to date
  --killed  also runs each block again with bad files added, killed three times and resumed, and on one thread
            (bench/resume.py; depth maps at a quarter of the resolution): the products must be the same, bit for bit
Needs python3-numpy.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import time

import numpy as np

from truth import STRECHA, centre_errors, park_gate_centres, strecha_centres

parser = argparse.ArgumentParser()
root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
parser.add_argument("--data", default=os.path.join(os.path.dirname(root), "shared", "data"))
parser.add_argument("--out", default=os.path.join(root, "build", "bench-accuracy"))
parser.add_argument("--only", default="")
parser.add_argument("--collinea", default=os.path.join(root, "build", "release", "bin", "collinea"))
parser.add_argument("--killed", action="store_true")
args = parser.parse_args()


failures = 0


def failed(text):
    """Says it, and has the program end with an error."""
    global failures
    failures += 1
    print(text, flush=True)


def collinea(*words):
    """Runs the program; its own messages go to our stderr. Returns (stdout, seconds)."""
    start = time.time()
    done = subprocess.run([args.collinea, *map(str, words)], stdout=subprocess.PIPE, text=True)
    if done.returncode:
        failed(f"FAILED ({done.returncode}): collinea {' '.join(map(str, words))}")
    return done.stdout, time.time() - start


def fresh(project):
    """Nothing of what an earlier build did is left in it."""
    shutil.rmtree(project, ignore_errors=True)
    return project


def info(project):
    out, _ = collinea("info", project, "--json")
    return json.loads(out) if out else {}


def oriented_centre_errors(project, truth):
    folder = os.path.join(project, "colmap")
    collinea("export", project, folder, "--format", "colmap")
    return centre_errors(folder, truth)


def row(*cells):
    print("| " + " | ".join(str(c) for c in cells) + " |", flush=True)


def oriented(i):
    return f"{i.get('oriented', 0)}/{i.get('images', 0)}"


def axes(v):
    return "-" if not v else "/".join("-" if x is None else f"{x:.3f}" for x in v)


def cost(i):
    if not i.get("steps"):
        return "-"
    return f"{sum(s['seconds'] for s in i['steps']):.0f} s, {max(s['peak_memory_bytes'] for s in i['steps']) / 1e6:.0f} MB"


def demo(out):
    block, project = os.path.join(out, "block"), os.path.join(out, "project")
    if not os.path.exists(os.path.join(block, "truth", "dtm.tif")):
        collinea("simulate", block)
    collinea("run", os.path.join(block, "images"), "-o", fresh(project), "--control", os.path.join(block, "control.csv"))
    i = info(project)
    assessed, _ = collinea("assess", project, os.path.join(block, "truth"))
    row("demo", oriented(i), f"check RMSE {axes(i.get('check_rmse_m'))} m, GSD {i.get('gsd_m', 0):.3f} m", cost(i))
    print("\n".join("    " + l for l in assessed.splitlines()))


def strecha(name):
    def bench(out):
        data = os.path.join(args.data, "strecha2008", name)
        truth = strecha_centres(data)
        for kind, extra in (("known camera", ["--camera-params", STRECHA[name]]), ("self-calibrated", [])):
            project = os.path.join(out, kind.split()[0])
            collinea("run", os.path.join(data, "images"), "-o", fresh(project), "--until", "adjust", *extra)
            i, e = info(project), oriented_centre_errors(project, truth)
            text = "none" if e is None else f"centres mean {1000 * e.mean():.2f} mm, max {1000 * e.max():.2f} mm"
            row(name + ", " + kind, oriented(i), text, cost(i))
    return bench


def park_gate(out):
    data = os.path.join(args.data, "park_gate")
    truth = park_gate_centres(os.path.join(data, "P_reference_halfres.txt"))
    collinea("run", os.path.join(data, "images"), "-o", fresh(out), "--until", "adjust")
    i, e = info(out), oriented_centre_errors(out, truth)
    spread = np.linalg.norm(np.std(list(truth.values()), axis=0))
    text = "none" if e is None else f"centres mean {100 * e.mean() / spread:.2f} %, max {100 * e.max() / spread:.2f} % of their spread"
    row("park_gate, self-calibrated", oriented(i), text, cost(i))


def real(folder, until, extra, text):
    def bench(out):
        data = os.path.join(args.data, folder)
        words = [w.replace("DATA", data) for w in extra]
        collinea("run", os.path.join(data, "images"), "-o", fresh(out), "--until", until, *words)
        i = info(out)
        row(folder, oriented(i), text(i), cost(i))
        for finding in i.get("findings", []):
            print(f"    {finding['severity']}: {finding['what']} {finding['remedy']}")
    return bench


def points(i):
    return f"{i['tie_points']} points, mean {i['mean_reprojection_px']:.3f} px"


BLOCKS = {
    "demo": demo,
    **{name: strecha(name) for name in STRECHA},
    "sceaux_castle": real("sceaux_castle", "adjust", [], points),
    "park_gate": park_gate,
    # Coordinates rounded to 0.1 m, and two marks in three projected by another program, not measured (bench/rays.py): what
    # control can tell is a decimetre.
    "oppaiyama": real("oppaiyama", "adjust", ["--control", "DATA/gcp_list.txt"],
                      lambda i: points(i) + f", {1 + len(i.get('other_parts', []))} part, control {axes(i.get('control_rmse_m'))} m"),
    "ioniq5": real("ioniq5", "adjust", ["--control", "DATA/gcp_list.txt"],
                   lambda i: points(i) + f", control {axes(i.get('control_rmse_m'))} (units of the list)"),
    "brighton_beach": real("brighton_beach", "report", [],
                           lambda i: points(i) + f", GPS RMS {axes(i.get('position_rms_m'))} m"),
    "sheffield_cross": real("sheffield_cross", "report", ["--control", "DATA/gcp_list.txt", "--check", "gcp2,gcp4"],
                            lambda i: points(i) + f", control {axes(i.get('control_rmse_m'))}, check {axes(i.get('check_rmse_m'))} m"),
    "odm_copr": real("odm_copr", "report", ["--control", "DATA/gcp_list.txt"],
                     lambda i: points(i) + f", control {axes(i.get('control_rmse_m'))} m"),
}

def killed(name, out):
    photos, control = os.path.join(args.data, "strecha2008" if name in STRECHA else "", name, "images"), None
    if name == "demo":
        photos, control = os.path.join(out, "block", "images"), os.path.join(out, "block", "control.csv")
    elif os.path.exists(os.path.join(args.data, name, "gcp_list.txt")):
        control = os.path.join(args.data, name, "gcp_list.txt")
    words = [sys.executable, os.path.join(root, "bench", "resume.py"), photos, "--out", os.path.join(out, "killed"),
             "--collinea", args.collinea] + (["--control", control] if control else [])
    done = subprocess.run([*words, "--", "--resolution", "quarter"], stdout=subprocess.PIPE, text=True)
    lines = done.stdout.splitlines()
    if done.returncode:
        failed(f"FAILED ({done.returncode}): {' '.join(words)}")
    different = [l.split()[-1] for l in lines if l.startswith("DIFFERENT") or l.startswith("NOT NAMED")]
    for d in different:
        failed("DIFFERENT " + d)
    text = f"{sum(l.startswith('same') for l in lines)} files the same, {sum(l.startswith('named') for l in lines)} bad photographs named"
    row(name + ", killed 3 times, 1 thread", "failed" if done.returncode else "same", text + "".join(", DIFFERENT " + d for d in different), "-")


row("block", "oriented", "result", "cost")
row("---", "---", "---", "---")
for name, bench in BLOCKS.items():
    if args.only and name not in args.only.split(","):
        continue
    folder = "strecha2008/" + name if name in STRECHA else name
    if name != "demo" and not os.path.isdir(os.path.join(args.data, folder)):
        print(f"{name}: skipped, no {os.path.join(args.data, folder)}")
        continue
    out = os.path.join(args.out, name)
    os.makedirs(out, exist_ok=True)
    bench(out)
    if args.killed:
        killed(name, out)
if failures:
    sys.exit(f"{failures} failures, see above")
