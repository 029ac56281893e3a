#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Independent models beside the bundle of the same measurements, on simulated blocks with known truth.

usage: bench/models.py [--collinea PROGRAM] [--seeds N] [--strips N] [--images N] [--keep FOLDER]
Writes an adjustment file for each seed (nadir photographs, forward overlap 60 %, side overlap 30 %, control at the corners and
heights along the ends of the strips), joins its models with `collinea models --anblock` and adjusts the bundle with `collinea
adjust --import`, and prints: RMS error and RMS sigma of both, the ratio of their sigmas, what they differ by in sigmas, the mean
of chi-squared over degrees of freedom and the share of points within the 95 % bound.
"""
import argparse
import csv
import pathlib
import subprocess
import tempfile

import numpy as np

FOCAL, WIDTH, HEIGHT = 10000.0, 15330, 15330  # px: a photograph of 23 cm at 15 um, c = 150 mm
FLYING, SIGMA_PX, SIGMA_CONTROL = 1000.0, 0.4, 0.02
FRAME = WIDTH / FOCAL * FLYING  # m on the ground


def rotation(omega, phi, kappa):
    co, so, cp, sp, ck, sk = np.cos(omega), np.sin(omega), np.cos(phi), np.sin(phi), np.cos(kappa), np.sin(kappa)
    rx = np.array([[1, 0, 0], [0, co, -so], [0, so, co]])
    ry = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    rz = np.array([[ck, -sk, 0], [sk, ck, 0], [0, 0, 1]])
    return rx @ ry @ rz  # ground from image (x right, y up, z backward)


class Block:
    def __init__(self, seed, strips, images):
        random = np.random.default_rng(seed)
        base, across = 0.4 * FRAME, 0.7 * FRAME
        self.poses, self.points, self.control, self.seen = {}, {}, {}, []
        for strip in range(strips):
            for k in range(images):
                angles = np.radians(random.normal(0, 1.5, 3)) + [0, 0, np.pi * (strip % 2)]
                centre = np.array([k * base, strip * across, FLYING + 100]) + random.normal(0, 8, 3)
                self.poses[f"s{strip}_{k}"] = (centre, angles)
        number = 0
        for column in range(images):  # below each centre: six and more of a model, in three bands of each strip
            for strip in range(strips):
                for y in (-0.42, -0.33, -0.04, 0.04, 0.33, 0.42):
                    x = column * base + random.normal(0, 20)
                    self.points[number] = np.array([x, (strip + y) * across + random.normal(0, 15),
                                                    100 + 40 * np.sin(x / 300) + random.normal(0, 10)])
                    number += 1
        low, high = -0.33 * across, (strips - 1 + 0.33) * across
        for name, x, y, height_only in (
            [(f"C{i}", x, y, False) for i, (x, y) in enumerate([(0, low), (0, high), ((images - 1) * base, low),
                                                               ((images - 1) * base, high), ((images - 1) / 2 * base, low),
                                                               ((images - 1) / 2 * base, high)])]
            + [(f"H{s}_{e}", e * (images - 1) / 2 * base, s * across + 0.5 * across, True)
               for s in range(strips - 1) for e in range(3)]):
            self.control[name] = (np.array([x, y, 100 + 40 * np.sin(x / 300)]) + random.normal(0, 5, 3), height_only)
        truth = [(str(n), p, False) for n, p in self.points.items()] + [(n, p, True) for n, (p, _) in self.control.items()]
        for image, (centre, angles) in self.poses.items():
            ground_from_image = rotation(*angles)
            for name, point, is_control in truth:
                d = ground_from_image.T @ (point - centre)
                column = WIDTH / 2 + FOCAL * d[0] / -d[2]
                row = HEIGHT / 2 - FOCAL * d[1] / -d[2]
                if 200 < column < WIDTH - 200 and 200 < row < HEIGHT - 200:
                    noise = random.normal(0, SIGMA_PX, 2)
                    self.seen.append((image, name, is_control, column + noise[0], row + noise[1]))
        self.given = {n: p + random.normal(0, SIGMA_CONTROL, 3) for n, (p, _) in self.control.items()}
        self.random = random

    def write(self, path):
        lines = ["collinea-adjustment 1", f'camera rc30 {WIDTH} {HEIGHT} brown', f"parameter rc30 f {FOCAL} fixed"]
        for image, (centre, angles) in self.poses.items():
            start = centre + self.random.normal(0, 1, 3)
            lines.append(f"image {image} rc30")
            lines.append(f"pose {image} " + " ".join(f"{v:.6f}" for v in [*start, *np.degrees(angles)]))
        for name, (_, height_only) in self.control.items():
            x, y, z = self.given[name]
            s = SIGMA_CONTROL
            lines.append(f"control {name} - - {z:.5f} - - {s}" if height_only else f"control {name} {x:.5f} {y:.5f} {z:.5f} {s} {s} {s}")
        counts = {}
        for _, name, _, _, _ in self.seen:
            counts[name] = counts.get(name, 0) + 1
        for image, name, is_control, column, row in self.seen:
            if counts[name] > 1:
                lines.append(f"measured_{'control' if is_control else 'tie'} {image} {name} {column:.5f} {row:.5f} {SIGMA_PX}")
        path.write_text("\n".join(lines) + "\n")


def table(path, separator=None):
    lines = [l for l in path.read_text().splitlines() if l and not l.startswith("#")]
    titles = [t.split("[")[0] for t in lines[0].split(separator)]
    return [dict(zip(titles, l.split(separator))) for l in lines[1:]]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--collinea", default="build/release/bin/collinea")
    arguments.add_argument("--seeds", type=int, default=20)
    arguments.add_argument("--strips", type=int, default=4)
    arguments.add_argument("--images", type=int, default=11)
    arguments.add_argument("--keep", type=pathlib.Path)
    asked = arguments.parse_args()
    sums = {}
    with tempfile.TemporaryDirectory() as temporary:
        folder = asked.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        for seed in range(1, asked.seeds + 1):
            block = Block(seed, asked.strips, asked.images)
            block.write(folder / "block.txt")
            run(asked.collinea, folder)
            gather(block, folder, sums)
    show(sums, asked)


def run(program, folder):
    for command in (["models", folder / "block.txt", "--anblock", "--out", folder / "models"],
                    ["adjust", "--import", folder / "block.txt", "--output", folder / "bundle", "--loss", "none"]):
        done = subprocess.run([program, *map(str, command), "--progress", "none"], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"{command[0]}: {done.stdout}{done.stderr}")
        (folder / f"{command[0]}.log").write_text(done.stdout)


def positions(rows, names):
    return {r["point"].strip('"'): np.array([[float(r[n]) for n in names[:3]], [float(r[n]) for n in names[3:]]]) for r in rows}


def gather(block, folder, sums):
    with open(folder / "bundle" / "points.csv", newline="") as file:
        bundle = positions(csv.DictReader(file), ["x_in_world_m", "y_in_world_m", "z_in_world_m", "sigma_x_m", "sigma_y_m", "sigma_z_m"])
    rows = table(folder / "models" / "points.txt")
    models = positions(rows, ["X", "Y", "Z", "sigma_X", "sigma_Y", "sigma_Z"])
    cycles = positions(rows, ["anblock_X", "anblock_Y", "anblock_Z", "anblock_sigma_X", "anblock_sigma_Y", "anblock_sigma_Z"])
    for number, truth in block.points.items():
        name = str(number)
        if name not in bundle or name not in models:
            continue
        for method, found in (("bundle", bundle), ("models", models), ("anblock", cycles)):
            position, sigma = found[name]
            sums.setdefault(method, []).append(np.concatenate([position - truth, sigma, position - bundle[name][0], bundle[name][1]]))
    for method, text in (("models", "models.log"),):
        line = next(l for l in (folder / text).read_text().splitlines() if l.startswith("sigma0"))
        sums.setdefault("sigma0", []).append(float(line.split()[1].rstrip(":")))


def show(sums, asked):
    print(f"{asked.seeds} blocks of {asked.strips} strips of {asked.images} photographs; sigma0 of the models {np.mean(sums['sigma0']):.3f}")
    print("method   axis  RMS error  RMS sigma  error/sigma  within 95 %  sigma/bundle  differs from bundle in its sigmas")
    for method in ("bundle", "models", "anblock"):
        all_of = np.array(sums[method])
        for axis in range(3):
            error, sigma, apart, of_bundle = (all_of[:, axis + 3 * k] for k in range(4))
            reduced = error / sigma
            print(f"{method:<8} {'XYZ'[axis]}  {np.sqrt(np.mean(error**2)):10.4f} {np.sqrt(np.mean(sigma**2)):10.4f} "
                  f"{np.sqrt(np.mean(reduced**2)):12.3f} {100 * np.mean(np.abs(reduced) < 1.96):12.1f} "
                  f"{np.sqrt(np.mean((sigma / of_bundle)**2)):13.3f} {np.sqrt(np.mean((apart / of_bundle)**2)):16.3f}")


if __name__ == "__main__":
    main()
