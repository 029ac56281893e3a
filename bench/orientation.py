#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""From photographs to oriented images: collinea and COLMAP on the same images, as tables of medians.

usage: bench/orientation.py [--data DIR] [--out DIR] [--sections NAME,...] [--only BLOCK,...] [--repeats N]
                            [--peer-cache DIR] [--collinea PROGRAM] [--graf PROGRAM]
  --data        folder of the real blocks (default ../shared/data); blocks that are not there are skipped, saying so
  --out         where projects go (default build/bench-orientation); what is there is removed first
  --sections    speed: processor time, wall time and memory of every stage; accuracy: errors of the centres;
                features: repeatability and matches on known homographies (default: all)
  --only        blocks of a section
  --repeats     runs of each program on each block (default 3)
  --peer-cache  folder of COLMAP's results, used and added to: its runs take minutes
  --graf        collinea_bench_graf, built where CMake is given -DCOLLINEA_BENCH=ON and finds OpenCV
Needs python3-numpy and colmap (COLMAP runs on the processor with its defaults; one camera for all images; exhaustive
pairs). Processor time is user + system of the processes; ratios are ours over COLMAP's.
"""
import argparse
import os
import shutil
import subprocess
import sys

import measure
import peer_colmap
import truth

parser = argparse.ArgumentParser()
root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
program = os.path.join(root, "build", "release", "bin", "collinea")
parser.add_argument("--data", default=os.path.join(os.path.dirname(root), "shared", "data"))
parser.add_argument("--out", default=os.path.join(root, "build", "bench-orientation"))
parser.add_argument("--sections", default="")
parser.add_argument("--only", default="")
parser.add_argument("--repeats", type=int, default=3)
parser.add_argument("--peer-cache", default="")
parser.add_argument("--collinea", default=program)
parser.add_argument("--graf", default=program + "_bench_graf")
args = parser.parse_args()

SCEAUX = "2905.88,2905.88,1416,1064"
STAGES = ("detect", "match", "orient")


def data(*parts):
    return os.path.join(args.data, *parts)


def wanted(name, folder):
    if args.only and name not in args.only.split(","):
        return False
    if not os.path.isdir(folder):
        print(f"{name}: skipped, no {folder}")
        return False
    return True


def run_ours(images, camera_params, project, extra_detect=()):
    """Costs by stage and the folder of the oriented model as text."""
    shutil.rmtree(project, ignore_errors=True)
    os.makedirs(project)
    log = project + ".log"
    known = ["--camera-params", camera_params] if camera_params else []
    costs = {"import": measure.run([args.collinea, "import", images, "-o", project, *known], log),
             "detect": measure.run([args.collinea, "detect", project, *extra_detect], log),
             "match": measure.run([args.collinea, "match", project], log),
             "orient": measure.run([args.collinea, "orient", project], log)}
    model = os.path.join(project, "colmap")
    measure.run([args.collinea, "export", project, model, "--format", "colmap"], log)
    return costs, model


def ours(name, images, camera_params, extra_detect=()):
    """`repeats` runs: median cost of each stage and the model of the last."""
    runs = [run_ours(images, camera_params, os.path.join(args.out, name), extra_detect) for _ in range(args.repeats)]
    costs = {stage: measure.median_cost([r[0][stage] for r in runs]) for stage in runs[0][0]}
    costs["all"] = measure.median_cost([sum(r[0].values(), measure.Cost()) for r in runs])
    return costs, runs[-1][1]


def peer(name, images, camera_params):
    runs = peer_colmap.runs(name, images, camera_params, args.repeats, args.out, args.peer_cache)
    costs = {stage: measure.median_cost([r.costs[stage] for r in runs]) for stage in STAGES}
    costs["all"] = measure.median_cost([sum(r.costs.values(), measure.Cost()) for r in runs])
    return costs, runs[-1]


def cost_rows(name, mine, others):
    measure.row(name, "COLMAP", *(f"{others[s].cpu_s:.1f}" for s in (*STAGES, "all")),
                f"{others['all'].wall_s:.1f}", f"{others['all'].peak_bytes / 1e6:.0f}")
    measure.row(name, "collinea", *(f"{mine[s].cpu_s:.2f}" for s in (*STAGES, "all")),
                f"{mine['all'].wall_s:.1f}", f"{mine['all'].peak_bytes / 1e6:.0f}")
    measure.row(name, "ratio", *(f"1/{others[s].cpu_s / mine[s].cpu_s:.1f}" for s in (*STAGES, "all")),
                f"1/{others['all'].wall_s / mine['all'].wall_s:.1f}",
                f"1/{others['all'].peak_bytes / mine['all'].peak_bytes:.1f}")


def speed():
    print(f"\nCost, medians of {args.repeats} runs on {peer_colmap.machine()}\n")
    measure.head("block", "program", "detect CPU-s", "match + verify CPU-s", "orient CPU-s", "all CPU-s", "all wall s",
                 "peak MB")
    for name, folder, camera in (("sceaux_castle", data("sceaux_castle"), SCEAUX),
                                 ("fountain-P11", data("strecha2008", "fountain-P11"), truth.STRECHA["fountain-P11"])):
        if not wanted(name, folder):
            continue
        images = os.path.join(folder, "images")
        others, run = peer(name, images, camera)
        mine, _ = ours(name, images, camera)
        cost_rows(name, mine, others)
        count = round(run.features)
        same, _ = ours(name + "-same", images, camera, ["--max-features", count])
        cost_rows(f"{name}, {count} features an image", same, others)


def accuracy_blocks():
    for name, camera in truth.STRECHA.items():
        folder = data("strecha2008", name)
        yield name, folder, camera, lambda f: truth.strecha_centres(f), 1000, "mm"
    yield ("park_gate", data("park_gate"), "1234.537,1247.617,488.137,316.756",
           lambda f: truth.camera_matrix_centres(os.path.join(f, "P_reference_halfres.txt")), 1, "units of the reference")


def shown_errors(model, oriented, images, centres, factor, unit):
    errors = truth.centre_errors(model, centres) if model else None
    text = "-" if errors is None else f"{factor * errors.mean():.2f} {unit} (max {factor * errors.max():.2f})"
    return f"{oriented}/{images}", text


def accuracy():
    print("\nMean error of the projection centres after the best similarity\n")
    measure.head("block", "camera", "COLMAP oriented", "COLMAP error", "collinea oriented", "collinea error")
    for name, folder, camera, centres_in, factor, unit in accuracy_blocks():
        if not wanted(name, folder):
            continue
        images, centres = os.path.join(folder, "images"), centres_in(folder)
        count = len([f for f in os.listdir(images) if f.lower().endswith((".jpg", ".png"))])
        for kind, params in (("known", camera), ("self-calibrated", None)):
            label = name if params else name + "-self"
            _, run = peer(label, images, params)
            _, model = ours(label, images, params)
            found = len(truth.centres_of_model(model))
            measure.row(name, kind, *shown_errors(run.model, run.oriented, count, centres, factor, unit),
                        *shown_errors(model, found, count, centres, factor, unit))


def features():
    folder = data("oxford_graf", "graf")
    if not wanted("graf", folder):
        return
    if not os.path.exists(args.graf):
        print(f"features: skipped, no {args.graf}")
        return
    print("\nFeatures of the first graf picture found again in the others, as many of each detector\n", flush=True)
    subprocess.run([args.graf, folder], check=True)


SECTIONS = {"speed": speed, "accuracy": accuracy, "features": features}

if __name__ == "__main__":
    for chosen in args.sections.split(",") if args.sections else SECTIONS:
        if chosen not in SECTIONS:
            sys.exit(f"no section {chosen}; there are {', '.join(SECTIONS)}")
        SECTIONS[chosen]()
