#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The two experiments of Karfis (2009) on simulated film whose surface is known exactly: tables in Markdown.

usage: bench/karfis.py --collinea PROGRAM --work DIR [--scenes volos volos_village kea] [--scan-um UM] [--resolution WORD] [--surfaces levels dense]
                       [--grid-px N] [--kinds full coarse] [--threads N]

Renders a pair of film of each scene (`simulate --film`, 60 % forward overlap): volos, a town at 1:6800, volos_village, scattered houses
at 1:6800, and kea, rocks at 1:10000. Runs `pair` with twelve points of control, and compares with `evaluate` after three shifts: the
surface model's cells, all of them and the measured ones, with the exact surface; the points of the cloud with it; and nine squares of
150 m, as his sub-areas were, which are not shifted: some hold too little to be brought together by. The tolerances are his. The last row
is the exact surface displaced to the east by one pixel of the scans, beside itself: what walls alone make of so small an error of
position. A pair that is in DIR already is not rendered again.
"""
import argparse
import csv
import math
import pathlib
import shutil
import statistics
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import measure  # noqa: E402

# Country, scale number, micrometres of his full and reduced scans, and his sigma of a difference for each [m].
SCENES = {"volos": ("town", 6800, 15, 0.26, 64, 0.79), "volos_village": ("village", 6800, 15, 0.26, 64, 0.79),
          "kea": ("rocks", 10000, 11, 0.29, 49, 0.92)}
HIS = {("volos", "full"): "0.71 | 56.1 82.9 87.2 90.8 93.4 | 1.3", ("volos", "coarse"): "1.90 | 10.7 79.9 95.5 98.9 99.7 | 0.0",
       ("kea", "full"): "0.81-0.96 | 22.9-34.1 71.5-78.9 83.4-86.7 89.3-90.9 92.7-93.9 | 0.6-1.8",
       ("kea", "coarse"): "1.1 | 68.5 97.8 99.3 99.6 99.7 | 0.0"}
HIS.update({("volos_village", kind): HIS["volos", kind] for kind in ("full", "coarse")})
SQUARE_M = 150
SEEN = 0.35  # part of the truth's extent, from its middle, over which the squares are spread


def write_control(block):
    """The control of a simulated pair as `pair` reads it."""
    points, seen = {}, {}
    for line in (block / "control.csv").read_text().splitlines():
        words = [word.strip() for word in line.split(",")]
        if words[0] == "point" and words[8] == "control":
            points[words[1]] = words[2:8]
        elif words[0] == "image":
            seen.setdefault(words[1], {})[words[2]] = words[3:5]
    rows = ["point X[m] Y[m] Z[m] sigma_X[m] sigma_Y[m] sigma_Z[m] x_left[px] y_left[px] x_right[px] y_right[px]"]
    for name, ground in points.items():
        if len(seen.get(name, {})) == 2:
            rows.append(" ".join([name, *ground, *(value for file in sorted(seen[name]) for value in seen[name][file])]))
    (block / "control.txt").write_text("\n".join(rows) + "\n")


def simulated(asked, scene, scan_um, seed=1):
    block = asked.work / f"{scene}_{scan_um:g}_{seed}"
    if not (block / "control.txt").exists():
        country, scale = SCENES[scene][:2]
        shutil.rmtree(block, ignore_errors=True)
        cost = measure.run([asked.collinea, "simulate", block, "--film", "--country", country, "--photo-scale", scale, "--scan-um", scan_um,
                            "--strips", 1, "--images-per-strip", 2, "--control-points", 12, "--check-points", 6, "--seed", seed,
                            "--threads", asked.threads, "--progress", "none"], log=asked.work / "log.txt")
        print(f"{block.name}: rendered in {cost.wall_s:.0f} s, {cost.cpu_s:.0f} s of processors, {cost.peak_bytes / 1e9:.1f} GB", flush=True)
        write_control(block)
    return block


def paired(asked, block, surface, extra=()):
    out = block / surface
    if not (out / "pair.txt").exists():
        cost = measure.run([asked.collinea, "pair", block / "images/IMG_0001.jpg", block / "images/IMG_0002.jpg", "-o", out, "--film",
                            block / "film_calibration.txt", "--control", block / "control.txt", "--control-sigma-px", 0.25, "--surface",
                            surface, "--resolution", asked.resolution, *(("--grid-px", asked.grid_px) if surface == "levels" else ()),
                            *extra, "--threads", asked.threads, "--progress", "none"], log=asked.work / "log.txt")
        print(f"{block.name} {surface}: {cost.wall_s:.0f} s, {cost.cpu_s:.0f} s of processors, {cost.peak_bytes / 1e9:.1f} GB", flush=True)
    return out


def evaluated(asked, surface, reference, tolerance, out, *more):
    """Rows of the table of `evaluate` by their names: count, mean, std, RMS, median, NMAD, shares."""
    measure.run([asked.collinea, "evaluate", surface, reference, "--tolerance-m", tolerance, "-o", out, "--threads", asked.threads, "--progress",
                 "none", *more], log=asked.work / "log.txt")
    rows = {}
    for line in (out / "evaluation.txt").read_text().splitlines():
        words = line.split()
        numbers = []
        while words and words[-1].replace(".", "").replace("-", "").isdigit():
            numbers.insert(0, float(words.pop()))
        if len(numbers) >= 12:
            rows[" ".join(words + [f"{n:g}" for n in numbers[:-12]])] = numbers[-12:]
        if "mean square of difference / sigma" in line:
            rows["sigma"] = float(line.split("sigma ")[1].split(",")[0])
    return rows


def grid_of(raster):
    """West, south, east, north of a GeoTIFF, by its tags of scale and tie point, and where in the file the west stands."""
    data = raster.read_bytes()[:16]
    with open(raster, "rb") as file:
        little = "<" if data[:2] == b"II" else ">"
        big = struct.unpack(little + "H", data[2:4])[0] == 43
        file.seek(struct.unpack(little + ("Q" if big else "I"), data[8:16] if big else data[4:8])[0])
        count = struct.unpack(little + ("Q" if big else "H"), file.read(8 if big else 2))[0]
        tags = {}
        for _ in range(count):
            entry = file.read(20 if big else 12)
            tag, kind = struct.unpack(little + "HH", entry[:4])
            number = struct.unpack(little + ("Q" if big else "I"), entry[4:12] if big else entry[4:8])[0]
            tags[tag] = (kind, number, entry[12:] if big else entry[8:])

        def whole(tag):
            kind, _, value = tags[tag]
            return struct.unpack(little + {3: "H", 4: "I", 16: "Q"}[kind], value[:{3: 2, 4: 4, 16: 8}[kind]])[0]

        def doubles(tag):
            file.seek(struct.unpack(little + ("Q" if big else "I"), tags[tag][2])[0])
            return struct.unpack(little + f"{tags[tag][1]}d", file.read(8 * tags[tag][1]))
        cell, tie = doubles(33550)[0], doubles(33922)
        at = struct.unpack(little + ("Q" if big else "I"), tags[33922][2])[0] + 24
        return tie[3], tie[4] - whole(257) * cell, tie[3] + whole(256) * cell, tie[4], little, at


def displaced(raster, by, out):
    """A copy of a GeoTIFF that lies so much farther to the east [m]."""
    west, *_, little, at = grid_of(raster)
    shutil.copy(raster, out)
    with open(out, "r+b") as file:
        file.seek(at)
        file.write(struct.pack(little + "d", west + by))
    return out


def squares_of(raster):
    west, south, east, north, *_ = grid_of(raster)
    for j in (-1, 0, 1):
        for i in (-1, 0, 1):
            x, y = (west + east) / 2 + i * SEEN * (east - west), (south + north) / 2 + j * SEEN * (north - south)
            yield f"{x - SQUARE_M / 2:.2f},{y - SQUARE_M / 2:.2f},{x + SQUARE_M / 2:.2f},{y + SQUARE_M / 2:.2f}"


def shares(row):
    return " ".join(f"{value:.1f}" for value in row[6:11]) + f" | {row[11]:.1f}"


def experiment(asked, scene, kind):
    _, _, full, full_sigma, coarse, coarse_sigma = SCENES[scene]
    scan_um = asked.scan_um or (full if kind == "full" else coarse)
    tolerance = full_sigma if kind == "full" else coarse_sigma
    block = simulated(asked, scene, scan_um)
    truth = block / "truth/dsm.tif"
    for surface in asked.surfaces if kind == "full" else ["levels"]:
        out = paired(asked, block, surface)
        name = f"{scene}, {scan_um:g} um, {surface}"
        cells = evaluated(asked, out / "dsm.tif", truth, tolerance, out / "cells")
        ratio = cells.get("sigma", float("nan"))
        for row, of in (("all", "all cells"), ("measured", "measured cells")):
            v = cells[row]
            print(f"| {name}, {of} | {int(v[0])} | {v[1]:.3f} | {v[3]:.3f} | {v[5]:.3f} | {shares(v)} | {ratio:.2f} |", flush=True)
        points = evaluated(asked, truth, out / "cloud.ply", tolerance, out / "points")["all"]
        print(f"| {name}, points | {int(points[0])} | {-points[1]:.3f} | {points[3]:.3f} | {points[5]:.3f} | {shares(points)} | |", flush=True)
        parts = []
        for number, area in enumerate(squares_of(truth)):
            parts.append(evaluated(asked, out / "dsm.tif", truth, tolerance, out / f"square_{number}", "--area", area,
                                   "--coregistration", "none")["all"])
        values = [part[3] for part in parts]
        below = [part[7] for part in parts]
        print(f"| {name}, nine squares | | | {min(values):.2f}-{max(values):.2f}, median {statistics.median(values):.2f} | | "
              f"below 3 sigma {min(below):.1f}-{max(below):.1f}, median {statistics.median(below):.1f} | | |", flush=True)
    moved = displaced(truth, scan_um * 1e-6 * SCENES[scene][1], block / "displaced.tif")
    floor = evaluated(asked, moved, truth, tolerance, block / "displaced", "--coregistration", "none")["all"]
    moved.unlink()
    print(f"| {scene}, {scan_um:g} um, exact, displaced by a pixel | {int(floor[0])} | {floor[1]:.3f} | {floor[3]:.3f} | {floor[5]:.3f} | "
          f"{shares(floor)} | |", flush=True)
    print(f"| {scene}, Karfis, {kind} | | | {HIS[scene, kind]} | |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--collinea", required=True)
    parser.add_argument("--work", required=True, type=pathlib.Path)
    parser.add_argument("--scenes", nargs="+", default=["volos", "volos_village", "kea"], choices=sorted(SCENES))
    parser.add_argument("--kinds", nargs="+", default=["full", "coarse"], choices=["full", "coarse"])
    parser.add_argument("--scan-um", type=float)
    parser.add_argument("--resolution", default="full")
    parser.add_argument("--surfaces", nargs="+", default=["levels", "dense"])
    parser.add_argument("--grid-px", type=int, default=4)
    parser.add_argument("--threads", type=int, default=2)
    asked = parser.parse_args()
    asked.work.mkdir(parents=True, exist_ok=True)
    print("| surface | count | bias [m] | RMS [m] | NMAD [m] | below 1, 3, 4, 5, 6 sigma [%] | beyond 10 [%] | squares of error over sigma |")
    print("|" + "---|" * 8)
    for scene in asked.scenes:
        for kind in asked.kinds:
            experiment(asked, scene, kind)


if __name__ == "__main__":
    main()
