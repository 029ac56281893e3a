#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How true to scale rectified pictures are: boards with known places on a simulated façade, found in the pictures.

usage: bench/rectify.py [--out DIR] [--collinea PROGRAM]
  --out   where the survey and the project go (default build/bench-rectify); its photographs are used again, the project is not
A board is symmetric about its centre: it is found where the picture is most like itself turned by 180 degrees.
Judged by pixels of the photograph on the wall: half of one (RMS, each way) where the camera is known, a whole one where the lens is not; of the
boards that a picture shows half must be found. Exit code 1: something is SHORT. Needs python3-numpy and python3-pil; a minute of processor time.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys

import numpy as np
from PIL import Image

CELL_M = 0.004  # a third of a pixel on the wall
BOARD_CELLS, SEARCH_CELLS = 14, 6  # half a board; how far it is looked for: farther off a window may be as symmetric
ALIKE = 0.8  # correlation
ON_PLANE_M = 0.01
PIXEL_M = 0.013  # of the photographs on the wall
LEAST_FOUND = 0.5

root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
parser = argparse.ArgumentParser()
parser.add_argument("--out", default=os.path.join(root, "build", "bench-rectify"))
parser.add_argument("--collinea", default=os.path.join(root, "build", "release", "bin", "collinea"))
args = parser.parse_args()
block, project = os.path.join(args.out, "block"), os.path.join(args.out, "project")


def collinea(*words):
    subprocess.run([args.collinea, *map(str, words)], stdout=subprocess.DEVNULL, check=True)


def rows_of(path):
    with open(path) as file:
        return [[field.strip() for field in line.split(",")] for line in file if line.strip() and line[0] != "#"]


def rectified(name, source, *words):
    """grey picture (nothing: 0), what is told of it"""
    out = os.path.join(args.out, name + ".png")
    collinea("rectify", source, "-o", out, "--cell-m", CELL_M, *words)
    with Image.open(out) as picture:
        rgba = np.asarray(picture.convert("RGBA")).astype(float)
    with open(os.path.join(args.out, name + ".json")) as file:
        return rgba[..., :3].mean(2) * (rgba[..., 3] > 0), json.load(file)


def around(picture, column, row):
    """The picture around a place, or None where it does not show all of it."""
    half = BOARD_CELLS + 2 * SEARCH_CELLS
    first_x, first_y = int(column) - half, int(row) - half
    part = picture[max(0, first_y):first_y + 2 * half, max(0, first_x):first_x + 2 * half]
    return None if part.shape != (2 * half, 2 * half) or (part == 0).any() else part


def board_near(picture, column, row):
    """The centre of the board [cells] near a place, or None where there is none."""
    n, r = BOARD_CELLS, 2 * SEARCH_CELLS  # r: in half cells
    part = around(picture, column, row)
    if part is None:
        return None
    turned = part[::-1, ::-1]
    likeness = np.empty((2 * r + 1, 2 * r + 1))  # at centres half a cell apart
    for j in range(-r, r + 1):
        for i in range(-r, r + 1):
            here = part[r + (j + 1) // 2:, r + (i + 1) // 2:][:2 * n, :2 * n]
            there = turned[r - j // 2:, r - i // 2:][:2 * n, :2 * n]
            likeness[j + r, i + r] = np.corrcoef(here.ravel(), there.ravel())[0, 1]
    j, i = np.unravel_index(likeness.argmax(), likeness.shape)
    if not (0 < i < 2 * r and 0 < j < 2 * r) or likeness[j, i] < ALIKE:
        return None

    def vertex(before, most, after):
        return 0.5 * (before - after) / (before - 2 * most + after)

    x = i - r + vertex(*likeness[j, i - 1:i + 2])
    y = j - r + vertex(*likeness[j - 1:j + 2, i])
    return int(column) + x / 2, int(row) + y / 2


def errors_of(picture, told, places):
    """of boards by name, found less expected [m], and how many are shown; places: on the plane"""
    errors, shown = {}, 0
    for name, (x, y) in places.items():
        expected = (x - told["left_m"]) / CELL_M, (told["top_m"] - y) / CELL_M
        shown += around(picture, *expected) is not None
        if found := board_near(picture, *expected):
            errors[name] = np.array([found[0] - expected[0], expected[1] - found[1]]) * CELL_M
    return errors, shown


short = []


def row(what, errors, shown, limit_px, more=""):
    rms = np.sqrt(np.mean(np.square(list(errors.values())), 0)) if errors else np.full(2, np.nan)
    ok = len(errors) >= LEAST_FOUND * shown > 0 and (rms <= limit_px * PIXEL_M).all()
    if not ok:
        short.append(what)
    print(f"| {what} | {len(errors)} of {shown} | {1000 * rms[0]:.1f}, {1000 * rms[1]:.1f} mm{more} | {1000 * limit_px * PIXEL_M:.1f} mm "
          f"| {'ok' if ok else 'SHORT'} |", flush=True)


if not os.path.exists(os.path.join(block, "truth", "marks.csv")):
    collinea("simulate", block, "--scene", "facade", "--stations", 6, "--facade-width-px", 1200, "--facade-height-px", 900)
shutil.rmtree(project, ignore_errors=True)
control = os.path.join(block, "control.csv")
collinea("run", os.path.join(block, "images"), "-o", project, "--control", control, "--until", "densify")
marks = rows_of(os.path.join(block, "truth", "marks.csv"))[1:]
names = [fields[0] for fields in marks]
world, on_map = np.array([f[2:5] for f in marks], float), np.array([f[5:8] for f in marks], float)
on_wall = {name: place[[0, 2]] for name, place in zip(names, world) if abs(place[1]) < ON_PLANE_M}  # which is the plane y = 0
print("| plane from | marks found | RMS x, y | wanted | verdict |\n| --- | --- | --- | --- | --- |")

low, high = on_map.min(0) - 1, on_map.max(0) + 1
picture, told = rectified("region", project, "--region", ",".join(f"{v:.3f}" for v in (*low[:2], *high[:2], low[2], high[2])))
# The frames of survey and project are shifted, but turned by nothing that would count here. Between map and frame is a
# similarity in plan.
plane = told["plane"]
middle = on_map.mean(0)
e, n = (on_map - middle)[:, 0], (on_map - middle)[:, 1]
zero, one = np.zeros(len(e)), np.ones(len(e))
design = np.concatenate([np.stack([e, -n, one, zero], 1), np.stack([n, e, zero, one], 1)])
a, b, x0, y0 = np.linalg.lstsq(design, np.concatenate([world[:, 0], world[:, 1]]), rcond=None)[0]
de, dn, dh = np.array(plane["origin_on_map"]) - middle
origin = np.array([a * de - b * dn + x0, b * de + a * dn + y0, dh + world[:, 2].mean()])
axes = np.array([plane["x_axis_in_world"], plane["y_axis_in_world"]])
places = dict(zip(names, (world - origin) @ axes.T))
row(f"region of the cloud ({plane['points']} points, {1000 * plane['rms_m']:.1f} mm off it)",
    *errors_of(picture, told, {name: places[name] for name in on_wall}), 0.5)

seen = {}
for fields in rows_of(control):
    if fields[0] == "image":
        seen.setdefault(fields[2], {})[fields[1]] = fields[3:5]
photo = max(sorted(seen), key=lambda file: len(seen[file].keys() & on_wall.keys()))
points = os.path.join(args.out, "points.csv")
with open(points, "w") as file:
    for name in sorted(seen[photo].keys() & on_wall.keys()):
        print(name, *seen[photo][name], *on_wall[name], 0.25, 0.001, sep=", ", file=file)
source = os.path.join(block, "images", photo)
for what, limit_px, words in (("camera of the project", 0.5, ["--project", project]), ("lens not known", 1, [])):
    picture, told = rectified("points", source, "--points", points, *words)
    row(f"{len(told['points'])} points measured in one photograph, {what}", *errors_of(picture, told, on_wall), limit_px,
        f"; sigma0 {told['sigma0']:.1f}" if "sigma0" in told else "")
    if centre := told["photographs"][0].get("centre_over_plane_m"):
        for name, place in zip(names, world):
            depth, at = -place[1], place[[0, 2]]
            shift = depth * (at - centre[:2]) / centre[2]
            if name not in on_wall and (error := errors_of(picture, told, {name: at + shift})[0]):
                print(f"    {name}, {1000 * depth:.0f} mm before the wall: shifted by {1000 * np.hypot(*shift):.0f} mm, as it must, but for "
                      f"{1000 * np.hypot(*error[name]):.0f} mm")
if short:
    sys.exit("SHORT: " + "; ".join(short))
