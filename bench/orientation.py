#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""From photographs to oriented images: collinea and COLMAP on the same images, as tables of medians.

usage: bench/orientation.py [--only SECTION,...] [--blocks BLOCK,...] [--data DIR] [--out DIR] [--repeats N]
                            [--peer-repeats N] [--peer-cache DIR] [--bundle-images N,N,...] [--collinea PROGRAM]
  --only          sections (default: all)
                    speed     processor time, wall time and memory of every stage
                    accuracy  errors of the projection centres
                    control   marks in pictures: how far from their common point
                    features  repeatability and matches on known homographies, beside OpenCV's SIFT
                    pairs     what the selection of pairs finds, and its cost (bench/pairs.py)
                    bundle    the bundle adjustment beside Ceres (bench/bundle)
                    scale     time and memory against the number of images (bench/scale.py)
  --blocks        blocks of the sections speed and accuracy
  --data          folder of the real blocks (default ../shared/data); blocks that are not there are skipped, saying so
  --out           where projects go (default build/bench-orientation); what is there is removed first
  --repeats       runs of ours on each block where costs are shown (default 3)
  --peer-repeats  runs of COLMAP where costs are shown (default: as many as of ours)
  --bundle-images sizes of the section bundle (default 100,500,2000; with 2000 Ceres takes many minutes)
  --peer-cache    folder of COLMAP's results, used and added to: its runs take minutes
Sections features and bundle need the programs built where CMake is given -DCOLLINEA_BENCH=ON and finds OpenCV or Ceres;
they are looked for beside the program.
Needs python3-numpy and colmap (COLMAP runs on the processor with its defaults; one camera for all images; exhaustive
pairs). Processor time is user + system of the processes; ratios are ours over COLMAP's.
"""
import argparse
import os
import shutil
import sqlite3
import subprocess
import sys

import numpy as np

import measure
import peer_colmap
import rays
import truth

parser = argparse.ArgumentParser()
root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
program = os.path.join(root, "build", "release", "bin", "collinea")
parser.add_argument("--data", default=os.path.join(os.path.dirname(root), "shared", "data"))
parser.add_argument("--out", default=os.path.join(root, "build", "bench-orientation"))
parser.add_argument("--only", default="")
parser.add_argument("--blocks", default="")
parser.add_argument("--repeats", type=int, default=3)
parser.add_argument("--peer-repeats", type=int, default=0)
parser.add_argument("--peer-cache", default="")
parser.add_argument("--bundle-images", default="100,500,2000")
parser.add_argument("--collinea", default=program)
args = parser.parse_args()
PEER_REPEATS = args.peer_repeats or args.repeats

SCEAUX = "2905.88,2905.88,1416,1064"
OPPAIYAMA_WIDTH_PX = 816
STAGES = ("detect", "match", "orient")


def data(*parts):
    return os.path.join(args.data, *parts)


def wanted(name, folder):
    if args.blocks and name not in args.blocks.split(","):
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


def ours(name, images, camera_params, repeats, extra_detect=()):
    """Median cost of each stage and the model of the last."""
    runs = [run_ours(images, camera_params, os.path.join(args.out, name), extra_detect) for _ in range(repeats)]
    costs = {stage: measure.median_cost([r[0][stage] for r in runs]) for stage in runs[0][0]}
    costs["all"] = measure.median_cost([sum(r[0].values(), measure.Cost()) for r in runs])
    return costs, runs[-1][1]


def peer(name, images, camera_params, repeats):
    runs = peer_colmap.runs(name, images, camera_params, repeats, args.out, args.peer_cache)
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
    print(f"\nCost, medians of {args.repeats} runs ({PEER_REPEATS} of COLMAP) on {peer_colmap.machine()}\n")
    measure.head("block", "program", "detect CPU-s", "match + verify CPU-s", "orient CPU-s", "all CPU-s", "all wall s",
                 "peak MB")
    for name, folder, camera in (("sceaux_castle", data("sceaux_castle"), SCEAUX),
                                 ("fountain-P11", data("strecha2008", "fountain-P11"), truth.STRECHA["fountain-P11"])):
        if not wanted(name, folder):
            continue
        images = os.path.join(folder, "images")
        others, run = peer(name, images, camera, PEER_REPEATS)
        mine, _ = ours(name, images, camera, args.repeats)
        cost_rows(name, mine, others)
        count = round(run.features)
        same, _ = ours(name + "-same", images, camera, args.repeats, ["--max-features", count])
        cost_rows(f"{name}, {count} features an image", same, others)


def accuracy_blocks():
    """name, folder, cameras to run with (None: found by the block itself), true centres, their factor and unit"""
    for name, camera in truth.STRECHA.items():
        yield name, data("strecha2008", name), (camera, None), truth.strecha_centres, 1000, "mm"
    yield ("park_gate", data("park_gate"), (truth.PARK_GATE, None),
           lambda f: truth.park_gate_centres(os.path.join(f, "P_reference_halfres.txt")), 1000,
           "thousandths of the reference's unit")


def shown_errors(model, oriented, images, centres, factor, unit):
    errors = truth.centre_errors(model, centres) if model else None
    text = "-" if errors is None else f"{factor * errors.mean():.2f} {unit} (max {factor * errors.max():.2f})"
    return f"{oriented}/{images}", text


def accuracy():
    print("\nMean error of the projection centres after the best similarity\n")
    measure.head("block", "camera", "COLMAP oriented", "COLMAP error", "collinea oriented", "collinea error")
    for name, folder, cameras, centres_in, factor, unit in accuracy_blocks():
        if not wanted(name, folder):
            continue
        images, centres = os.path.join(folder, "images"), centres_in(folder)
        count = len([f for f in os.listdir(images) if f.lower().endswith((".jpg", ".png"))])
        for params in cameras:
            kind, label = ("known", name) if params else ("self-calibrated", name + "-self")
            _, run = peer(label, images, params, 1)
            _, model = ours(label, images, params, 1)
            found = len(truth.centres_of_model(model))
            measure.row(name, kind, *shown_errors(run.model, run.oriented, count, centres, factor, unit),
                        *shown_errors(model, found, count, centres, factor, unit))


def taken_s(project):
    """Image name -> time of taking [s] of the day."""
    with sqlite3.connect(os.path.join(project, "block.db")) as db:
        times = dict(db.execute("select file, taken from images"))
    clock = {name: list(map(float, taken.split()[1].split(":"))) for name, taken in times.items() if taken}
    return {name: 3600 * h + 60 * m + s for name, (h, m, s) in clock.items()}


def control():
    """A third of the marks of oppaiyama were set by hand, on toys. The others are projections of the marks by the program
    that wrote them, with its own orientation: no measurements, but what a second orientation says. The two kinds mean
    points some centimetres apart, beside the toys, so that they have no common point."""
    folder = data("oppaiyama")
    if not os.path.isdir(folder):
        print(f"control: skipped, no {folder}")
        return
    print("\nMarks of oppaiyama: distances from their common point, and what pictures taken within a second of each other\n"
          "show of the pointing\n")
    measure.head("oriented", "marks", "rays", "median px", "90 % px", "largest px", "sigma of a coordinate px",
                 "of it pointing px")
    images = os.path.join(folder, "images")
    _, model = ours("oppaiyama", images, None, 1)
    marks = rays.marks_of(os.path.join(folder, "marker_fullres_photoscan.xml"), OPPAIYAMA_WIDTH_PX)
    times = taken_s(os.path.join(args.out, "oppaiyama"))
    for by_hand, label in ((True, "measured by hand"), (False, "projected by another program")):
        found = rays.errors_px(model, {mark: [(name, pixel) for name, pixel, hand in places if hand == by_hand]
                                       for mark, places in marks.items()})
        errors = np.array([error for places in found.values() for _, error in places]).reshape(-1, 2)
        lengths = np.linalg.norm(errors, axis=1) if len(errors) else np.full(1, np.nan)
        redundant = 2 * len(errors) - 3 * len(found)
        sigma = np.sqrt(np.square(errors).sum() / redundant) if redundant > 0 else np.nan
        measure.row(f"{len(truth.centres_of_model(model))}/{len(os.listdir(images))}", f"{len(found)} {label}",
                    len(errors), *(f"{np.quantile(lengths, q):.2f}" for q in (0.5, 0.9, 1)), f"{sigma:.2f}",
                    f"{rays.pointing_px(found, times):.2f}")


def beside(name):
    """A program of the benchmarks, or None, saying so."""
    path = os.path.join(os.path.dirname(os.path.abspath(args.collinea)), name)
    if not os.path.exists(path):
        print(f"skipped, no {path}")
        return None
    return path


def features():
    compared = beside("collinea_bench_graf")
    views = [("graf", data("oxford_graf", "graf")),
             ("fountain-P11 0000.jpg, warped", data("strecha2008", "fountain-P11", "images", "0000.jpg")),
             ("sceaux_castle 100_7104.JPG, warped", data("sceaux_castle", "images", "100_7104.JPG"))]
    for name, path in views if compared else ():
        if not os.path.exists(path):
            print(f"features: skipped, no {path}")
            continue
        print(f"\nFeatures of the first picture found again in the others, as many of each detector: {name}\n", flush=True)
        subprocess.run([compared, path], check=True)


def script(name, *words):
    print(flush=True)
    subprocess.run([sys.executable, os.path.join(root, "bench", name), "--collinea", args.collinea, "--out",
                    os.path.join(args.out, name.split(".")[0]), *words], check=True)


def pairs():
    script("pairs.py", "--data", args.data, "--repeats", str(args.repeats))


def bundle():
    compared = beside("collinea_bundle_bench")
    if compared:
        print(flush=True)
        subprocess.run([compared, "--repeats", str(args.repeats), "--images", args.bundle_images], check=True)


def scale():
    script("scale.py")


SECTIONS = {f.__name__: f for f in (speed, accuracy, control, features, pairs, bundle, scale)}

if __name__ == "__main__":
    chosen = args.only.split(",") if args.only else list(SECTIONS)
    unknown = [name for name in chosen if name not in SECTIONS]
    if unknown:
        sys.exit(f"no section {', '.join(unknown)}; there are {', '.join(SECTIONS)}")
    for name in chosen:
        SECTIONS[name]()
