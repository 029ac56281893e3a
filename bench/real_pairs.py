#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Interior, relative and absolute orientation of three real pairs, beside what their sets state: tables in Markdown.

usage: bench/real_pairs.py [--data DIR] [--out DIR] [--collinea PROGRAM] [--only 27,ar,wall]

DATA/film_pairs: pair_27_28 (four readers, eight control points) and rc30_AR112 (one reader, control in a band);
DATA/wall_pair: four photographs with stated lens and orientation, and nine ground points marked by hand. The tables that are made for the program, and what it
answers, stay in OUT. Exit code 1: a command failed.
"""
import argparse
import csv
import math
import pathlib
import shutil
import statistics
import subprocess
import sys
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parent.parent


class Program:
    def __init__(self, path, out):
        self.path, self.out = path, out

    def run(self, *arguments):
        """Its text; the command as one types it goes before the figures that come of it."""
        done = subprocess.run([self.path, *map(str, arguments)], cwd=self.out, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"collinea {' '.join(map(str, arguments))}: {done.stderr or done.stdout}")
        print(f"    collinea {' '.join(map(str, arguments))}")
        return done.stdout


def rows_of(path):
    """A text table as dictionaries; units in brackets are left out of the names."""
    lines = [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
    names = [word.split("[")[0] for word in lines[0]]
    return [dict(zip(names, row)) for row in lines[1:]]


def write_rows(path, header, rows):
    path.write_text("\n".join([header] + [" ".join(str(value) for value in row) for row in rows]) + "\n")


def table(header, rows):
    print("\n| " + " | ".join(header) + " |\n|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join(str(value) for value in row) + " |")
    print()


def rms(values):
    values = list(values)
    return math.sqrt(sum(v * v for v in values) / len(values))


# ---- film ----


def interior(program, name, pixel_um):
    text = program.run("interior", f"{name}_marks.txt", "--calibration", f"{name}_camera.txt", "--model", "affine",
                       "--pixel-um", pixel_um, "--points", f"{name}_points.txt", "-o", f"{name}_interior")
    for line in text.splitlines():
        if "gross and left out" in line or "mirror" in line:
            print("   ", line.strip())
    parameters, residuals = rows_of(program.out / f"{name}_interior/interior.txt"), rows_of(
        program.out / f"{name}_interior/residuals.txt")
    rows = []
    for image in dict.fromkeys(row["image"] for row in parameters):
        of = {r["parameter"]: r for r in parameters if r["image"] == image}
        v = [float(r[k]) for r in residuals if r["image"] == image for k in ("v_x", "v_y")]
        sigma0 = math.sqrt(sum(a * a for a in v) / (len(v) - 6))
        cell = lambda k, digits: f"{float(of[k]['value']):.{digits}f} ± {float(of[k]['sigma']):.{digits}f}"
        rows.append([image, cell("column", 2), cell("row", 2), cell("rotation", 4), cell("scale_x", 4),
                     cell("scale_y", 4), f"{1e6 * float(of['shear']['value']):.0f} ± {1e6 * float(of['shear']['sigma']):.0f}",
                     f"{sigma0:.2f}", f"{max(map(abs, v)):.2f}"])
    table(["image", "column [px]", "row [px]", "rotation [°]", "scale x [px/mm]", "scale y [px/mm]", "shear [ppm]",
           "sigma0 [px]", "largest residual [px]"], rows)
    return {(r["image"], r["point"]): (r["x"], r["y"]) for r in rows_of(program.out / f"{name}_interior/points.txt")}


def relative(program, name, points, left, right, distance):
    common = [p for image, p in points if image == left and (right, p) in points]
    write_rows(program.out / f"{name}_pair.txt", "point x_left[mm] y_left[mm] x_right[mm] y_right[mm]",
               [[p, *points[left, p], *points[right, p]] for p in common])
    program.run("relative", f"{name}_pair.txt", "--principal-distance", distance, "-o", f"{name}_relative")
    out = program.out / f"{name}_relative"
    print_relative(out, "mm", 1000, "um")
    return out


def print_relative(out, unit, factor, shown):
    table(["form", "element", "value", "sigma", "unit"],
          [[r["form"], r["element"], f"{float(r['value']):.5f}", f"{float(r['sigma']):.5f}", r["unit"]]
           for r in rows_of(out / "parameters.txt")])
    residuals = rows_of(out / "residuals.txt")
    key = "y_parallax"
    used = [r for r in residuals if r["used"] == "yes"]
    print(f"{len(used)} of {len(residuals)} points, y-parallax {factor * rms(float(r[key]) for r in used):.2f} {shown} RMS, "
          f"{factor * max(abs(float(r[key])) for r in used):.2f} {shown} at most\n")


def absolute(program, name, sigma_m, checks=()):
    out = f"{name}_absolute" + ("_check" if checks else "")
    arguments = ["absolute", f"{name}_relative/model.txt", f"{name}_ground.txt", "--sigma-ground", sigma_m, "-o", out]
    arguments += ["--check", ",".join(checks)] if checks else []
    text = program.run(*arguments)
    print("\n" + text)
    return program.out / out


def pair_27_28(program, data):
    print("## 27/28\n")
    (program.out / "27_camera.txt").write_text(
        "camera RC30\nprincipal_distance_mm 153.358\nprincipal_point_mm -0.006 0.006\n"
        "radial_correction 0.8878e-4 -0.1528e-7 0.5256e-12\ndecentring_correction 0.1346e-6 0.1224e-7\n"
        "mark 1 -105.997 -105.995\nmark 2 106.004 106.008\nmark 3 -106.000 106.009\nmark 4 106.012 -105.995\n"
        "mark 5 -112.000 0.007\nmark 6 112.006 0.007\nmark 7 0.005 112.007\nmark 8 0.002 -111.998\n")
    with open(data / "pair_27_28/measurements.csv") as file:
        rows = list(csv.DictReader(file))
    readings = lambda r: [(float(r[f"x{k}_px"]), float(r[f"y{k}_px"])) for k in range(1, 5)]
    write_rows(program.out / "27_marks.txt", "image mark x[px] y[px]",
               [[r["image"], r["id"], *xy] for r in rows if r["kind"] == "fiducial" for xy in readings(r)])
    write_rows(program.out / "27_points.txt", "image point x[px] y[px]",
               [[r["image"], r["id"], *(statistics.median(c) for c in zip(*readings(r)))] for r in rows
                if r["kind"] != "fiducial"])
    for kind in ("fiducial", "control", "tie"):
        off = [abs(v - statistics.median(c)) for r in rows if r["kind"] == kind for c in zip(*readings(r)) for v in c]
        print(f"readings of {kind}: farthest from their median {max(off):.1f} px, "
              f"{sum(o > 3 for o in off)} of {len(off)} coordinates by more than 3 px")
    with open(data / "pair_27_28/control.csv") as file:
        write_rows(program.out / "27_ground.txt", "point X[m] Y[m] Z[m]",
                   [[r["id"], r["x_m"], r["y_m"], r["z_m"]] for r in csv.DictReader(file)])
    points = interior(program, "27", 12)
    relative(program, "27", points, "27", "28", 153.358)
    absolute(program, "27", 0.3)
    absolute(program, "27", 0.3, ["102", "105", "201", "202"])


def phini_points(path):
    """Name -> (ground or None, {image: pixel}) of a file of the teaching program."""
    root = xml.etree.ElementTree.parse(path).getroot()
    number = lambda node, axis: float(node.find(f"d[@n='{axis}']").get("v"))
    found = {}
    for point in next(x for x in root.iter("x") if x.get("n") == "points").findall("x"):
        about = next(x for x in point.findall("x") if x.get("n") == "attributes")
        name = about.find("s[@n='name']").get("v").replace("*", "roof")
        ground = about.find("x[@n='coords_g']")
        pixels = {}
        for one in next(x for x in point.findall("x") if x.get("n") == "measurements").findall("x"):
            at = one.find("x[@n='coords_pix']")
            pixels[one.find("i").get("v")] = (number(at, "x"), number(at, "y"))
        found[name] = (None if ground is None else [number(ground, a) for a in "xyz"], pixels)
    return found


def pair_ar112(program, data):
    print("## AR112: 3574/3575\n")
    folder = data / "rc30_AR112"
    lines = (folder / "rc30.cam").read_text().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith("Fiducial"))
    marks = [line.split() for line in lines[first + 1:first + 9]]
    (program.out / "ar_camera.txt").write_text(
        "camera RC30\nprincipal_distance_mm 153.324\nprincipal_point_mm -0.002 0.004\n" +
        "".join(f"mark {i + 1} {x} {y}\n" for i, (x, y) in enumerate(marks)))
    rows = []
    for image in ("3574", "3575"):
        for i, line in enumerate((folder / f"fiducialsImg{image}.txt").read_text().splitlines()[1:]):
            rows.append([image, i + 1, *line.split()])
    write_rows(program.out / "ar_marks.txt", "image mark x[px] y[px]", rows)
    points = {}
    for name in ("lab5.xml", "Lab5P7-9.xml", "Lab6-Photomod.xml"):
        points.update(phini_points(folder / name))
    write_rows(program.out / "ar_points.txt", "image point x[px] y[px]",
               [[image, p, *xy] for p, (_, pixels) in points.items() for image, xy in pixels.items()])
    write_rows(program.out / "ar_ground.txt", "point X[m] Y[m] Z[m]",
               [[p, *ground] for p, (ground, _) in points.items() if ground])
    film = interior(program, "ar", 16)
    relative(program, "ar", film, "3574", "3575", 153.324)
    absolute(program, "ar", 0.1)


# ---- wall ----


def stated_pose(data, number):
    """Rotation from the world to the camera, by rows; the projection centre."""
    root = xml.etree.ElementTree.parse(data / f"Ori-PerspCentral-IMGP{number}.JPG.xml").getroot()
    read = lambda tag: [float(v) for v in root.find(f".//{tag}").text.split()]
    return [read(axis) for axis in ("AxeI", "AxeJ", "AxeK")], read("Center")


def rotation_of(quaternion):
    w, x, y, z = quaternion
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def turned(x, y, z):
    """Rz(z) Ry(y) Rx(x), degrees."""
    product = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    for axis, angle in ((0, x), (1, y), (2, z)):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        i, j = (axis + 1) % 3, (axis + 2) % 3
        one = [[float(a == b) for b in range(3)] for a in range(3)]
        one[i][i] = one[j][j] = c
        one[i][j], one[j][i] = -s, s
        product = [[sum(one[a][k] * product[k][b] for k in range(3)) for b in range(3)] for a in range(3)]
    return product


def between(first, second):
    """The rotation from the first camera to the second as a vector [deg], axes x right, y down, z forward."""
    r = [[sum(second[i][k] * first[j][k] for k in range(3)) for j in range(3)] for i in range(3)]
    angle = math.acos(max(-1.0, min(1.0, (r[0][0] + r[1][1] + r[2][2] - 1) / 2)))
    factor = math.degrees(angle / (2 * math.sin(angle)))
    return [factor * (r[2][1] - r[1][2]), factor * (r[0][2] - r[2][0]), factor * (r[1][0] - r[0][1])]


class StatedLens:
    def __init__(self, data):
        root = xml.etree.ElementTree.parse(data / "Calib-PerspCentral-Foc-28000_Cam-PENTAX_K5.xml").getroot()
        self.f = float(root.find(".//F").text)
        self.cx, self.cy = (float(v) for v in root.find(".//PP").text.split())
        self.k = [float(root.find(f".//K{i}").text) for i in (1, 2, 3)]

    def without_distortion(self, x, y):
        """The pixel that a lens without distortion would have."""
        u = v = 0.0
        a, b = (x - self.cx) / self.f, (y - self.cy) / self.f
        for _ in range(30):
            r2 = u * u + v * v
            factor = 1 + self.k[0] * r2 + self.k[1] * r2**2 + self.k[2] * r2**3
            u, v = a / factor, b / factor
        return self.f * u, self.f * v


def adjusted_poses(path):
    with open(path) as file:
        return {row["image"][4:8]: rotation_of([float(row[f"cam_from_map_q{k}"]) for k in "wxyz"])
                for row in csv.DictReader(file)}


def quoted(line):
    """The name in quotes of a line of an adjustment file, and the words after it."""
    return line.split('"')[1], line.split('"')[2].split()


def kept_images(block, images):
    """The adjustment file with some of its images alone, and their cameras."""
    seen = {}
    for line in block.splitlines():
        if line.startswith("measured_tie") and line.split()[1][4:8] in images:
            seen[line.split()[2]] = seen.get(line.split()[2], 0) + 1
    kept = []
    for line in block.splitlines():
        words = line.split()
        if words and words[0] in ("camera", "parameter"):
            number = quoted(line)[0].removeprefix("own ")
            if number.isdigit() and number not in images:
                continue
        elif any(w.startswith("IMGP") and w[4:8] not in images for w in words[1:2]):
            continue
        elif words and words[0] == "measured_tie" and seen.get(words[2], 0) < 2:
            continue
        kept.append(line)
    return "\n".join(kept) + "\n"


def with_own_cameras(block, images, how):
    """The adjustment file with a camera for each image; how(number, parameter, value) is how each of them is known."""
    lines = []
    parameters = [quoted(line)[1] for line in block.splitlines() if line.startswith("parameter ")]
    for line in block.splitlines():
        if line.startswith("camera "):
            name, rest = quoted(line)
            for number in images:
                lines.append(f'camera "own {number}" ' + " ".join(rest))
                lines += [f'parameter "own {number}" {words[0]} {how(number, words[0], words[1])}'
                          for words in parameters]
        elif line.startswith("image "):
            lines.append(f'image {line.split()[1]} "own {line.split()[1][4:8]}"')
        elif not line.startswith("parameter "):
            lines.append(line)
    return "\n".join(lines) + "\n"


def pair_alone(program, block, lens, pair):
    """The pair's own relative orientation, as a vector, from its tie points without distortion."""
    name = f"wall_{pair[0]}_{pair[1]}"
    write_rows(program.out / f"{name}.txt", "point x_left[px] y_left[px] x_right[px] y_right[px]",
               [[point, *xy[pair[0]], *xy[pair[1]]] for point, xy in pixels_of_ties(block, lens, pair).items()])
    program.run("relative", f"{name}.txt", "--principal-distance", lens.f, "-o", f"{name}_relative")
    print_relative(program.out / f"{name}_relative", "px", 1, "px")
    right = rows_of(program.out / f"{name}_relative/exterior.txt")[1]
    x, y, z = between(turned(0, 0, 0), turned(*(float(right[k]) for k in ("omega", "phi", "kappa"))))
    return [-x, y, z]  # of axes with y up and z backwards, from the image to the object


SIGMA_MATCH, SIGMA_MARK, SIGMA_GROUND = 0.2, 0.8, 0.01  # px, px, m


def pixels_of_ties(block, lens, pair):
    seen = {}
    for line in block.splitlines():
        words = line.split()
        if words and words[0] == "measured_tie" and words[1][4:8] in pair:
            seen.setdefault(words[2], {})[words[1][4:8]] = lens.without_distortion(float(words[3]), float(words[4]))
    return {point: xy for point, xy in seen.items() if len(xy) == 2}


def marked_by_hand(data, lens):
    """Ground points, and (image, point): pixel without distortion."""
    ground = {node.find("NamePt").text: node.find("Pt").text.split()
              for node in xml.etree.ElementTree.parse(data / "Ground-Pts3D.xml").getroot().iter("OneAppuisDAF")}
    marks = {}
    for image in xml.etree.ElementTree.parse(data / "GroundMeasure.xml").getroot().iter("MesureAppuiFlottant1Im"):
        for mark in image.iter("OneMesureAF1I"):
            x, y = (float(v) for v in mark.find("PtIm").text.split())
            marks[image.find("NameIm").text[4:8], mark.find("NamePt").text] = lens.without_distortion(x, y)
    return ground, marks


def stated_angles(data, number):
    """omega, phi, kappa of the stated attitude: axes x right, y up, z backwards."""
    rows, _ = stated_pose(data, number)
    m = [[rows[0][k], -rows[1][k], -rows[2][k]] for k in range(3)]
    return [math.degrees(a) for a in (math.atan2(-m[1][2], m[2][2]), math.asin(m[0][2]), math.atan2(-m[0][1], m[0][0]))]


def residual_table(rows, keys):
    table(["image", "point", *keys], [[r.get("image", ""), r["point"], *(r[k] for k in keys)] for r in rows])


def wall_marks(program, data, lens, numbers):
    """Resection of all images from the hand marks, and intersection of these by the stated orientations."""
    ground, marks = marked_by_hand(data, lens)
    write_rows(program.out / "wall_ground.txt", "point X[m] Y[m] Z[m]", [[p, *xyz] for p, xyz in ground.items()])
    write_rows(program.out / "wall_marks.txt", "image point x[px] y[px]", [[*key, *xy] for key, xy in marks.items()])
    poses = {n: [*stated_pose(data, n)[1], *stated_angles(data, n)] for n in numbers}
    write_rows(program.out / "wall_stated.txt", "image X[m] Y[m] Z[m] omega[deg] phi[deg] kappa[deg]",
               [[n, *pose] for n, pose in poses.items()])
    print("\n" + program.run("resection", "wall_marks.txt", "wall_ground.txt", "--principal-distance", lens.f, "-o",
                             "wall_resection"))
    rows = []
    for r in rows_of(program.out / "wall_resection/orientation.txt"):
        for k, name in enumerate(("X", "Y", "Z", "omega", "phi", "kappa")):
            off, sigma = float(r[name]) - poses[r["image"]][k], float(r["sigma_" + name])
            off -= 360 * round(off / 360) if k > 2 else 0
            rows.append([r["image"], name, f"{float(r[name]):.3f} ± {sigma:.3f}", f"{off:+.3f}", f"{off / sigma:+.1f}"])
    table(["image", "element", "by resection [m, °]", "less stated", "in sigmas"], rows)
    print((program.out / "wall_resection/residuals.txt").read_text())
    print("\n" + program.run("intersection", "wall_marks.txt", "wall_stated.txt", "--principal-distance", lens.f,
                             "--ground", "wall_ground.txt", "-o", "wall_intersection"))
    print((program.out / "wall_intersection/points.txt").read_text())
    print((program.out / "wall_intersection/residuals.txt").read_text())
    return ground, marks


def wall_absolute(program, block, lens, pair, ground, marks):
    """The pair with its hand marks on the ground."""
    common = [p for p in ground if all((n, p) in marks for n in pair)]
    name = f"wall_marked_{pair[0]}_{pair[1]}"
    rows = [[point, *xy[pair[0]], *xy[pair[1]], SIGMA_MATCH] for point, xy in pixels_of_ties(block, lens, pair).items()]
    rows += [[p, *marks[pair[0], p], *marks[pair[1], p], SIGMA_MARK] for p in common]
    write_rows(program.out / f"{name}.txt", "point x_left[px] y_left[px] x_right[px] y_right[px] sigma[px]", rows)
    program.run("relative", f"{name}.txt", "--principal-distance", lens.f, "-o", f"{name}_relative")
    print(f"\n{pair[0]}/{pair[1]}: {', '.join(common)}\n")
    print(program.run("absolute", f"{name}_relative/model.txt", "wall_ground.txt", "--sigma-ground", SIGMA_GROUND, "-o",
                      f"{name}_absolute"))


def wall(program, data):
    print("## Wall: 4167 to 4170\n")
    photos = program.out / "wall_photos"
    shutil.rmtree(photos, ignore_errors=True)
    shutil.rmtree(program.out / "wall", ignore_errors=True)
    photos.mkdir()
    for photo in data.glob("*.JPG"):
        shutil.copy(photo, photos)
    lens = StatedLens(data)
    numbers = ["4167", "4168", "4169", "4170"]
    pairs = [("4167", "4168"), ("4168", "4169"), ("4169", "4170"), ("4168", "4170")]
    stated = {n: stated_pose(data, n)[0] for n in numbers}
    program.run("import", "wall_photos", "-o", "wall", "--camera-params",
                f"{lens.f},{lens.f},{lens.cx},{lens.cy},{lens.k[0]},{lens.k[1]},{lens.k[2]},0,0")
    program.run("orient", "wall", "--calibration", "none", "--progress", "none")
    program.run("adjust", "wall", "--export", "wall_block.txt")
    block = (program.out / "wall_block.txt").read_text()
    ground, marks = wall_marks(program, data, lens, numbers)
    for pair in pairs:
        wall_absolute(program, block, lens, pair, ground, marks)
    rows, bundles = [], []

    def add(name, pair, vector):
        less = [a - b for a, b in zip(vector, between(stated[pair[0]], stated[pair[1]]))]
        rows.append([f"{pair[0]}, {pair[1]}", name, *(f"{a:.3f}" for a in vector),
                     *([""] * 3 if name == "stated" else [f"{a:+.3f}" for a in less])])

    def bundle(name, text, images, calibration):
        file = "wall_" + "_".join(name.replace(",", "").split())
        (program.out / f"{file}.txt").write_text(kept_images(text, images))
        answer = program.run("adjust", "--import", f"{file}.txt", "--output", file, "--calibration", calibration)
        sigma0 = next(line for line in answer.splitlines() if line.startswith("sigma0"))
        bundles.append([name, *(word.split()[1] for word in sigma0.split(",")[:2])])
        poses = adjusted_poses(program.out / file / "poses.csv")
        for pair in pairs:
            if set(pair) <= set(poses):
                add(name, pair, between(poses[pair[0]], poses[pair[1]]))
        with open(program.out / file / "cameras.csv") as cameras:
            return list(csv.DictReader(cameras))

    for pair in pairs:
        add("stated", pair, between(stated[pair[0]], stated[pair[1]]))
        add("pair by relative", pair, pair_alone(program, block, lens, pair))
    groups = [list(pair) for pair in pairs] + [numbers[:3], numbers[1:], numbers]
    for images in groups:
        bundle("stated lens, " + " ".join(images), block, images, "none")
    bundle("lens free (brown)", block, numbers, "brown")
    bundle("k1 of each image free", with_own_cameras(
        block, numbers, lambda n, k, value: f"{value} {'0.05' if k == 'k1' else 'fixed'}"), numbers, "auto")
    own = bundle("principal point of each image free", with_own_cameras(
        block, numbers, lambda n, k, value: f"{value} {'10' if k in ('cx', 'cy') else 'fixed'}"), numbers, "auto")
    value = {(r["camera"].removeprefix("own "), r["parameter"]): r for r in own}
    fixed = with_own_cameras(block, numbers, lambda n, k, _: f"{value[n, k]['value']} fixed")
    for images in groups:
        bundle("those principal points, " + " ".join(images), fixed, images, "none")
    table(["bundle", "sigma0 (of 0.5 px)", "redundancy"], bundles)
    table(["image", "cx [px]", "cy [px]"], [["stated", f"{lens.cx:.1f}", f"{lens.cy:.1f}"]] + [
        [n, *(f"{float(value[n, k]['value']):.1f} ± {float(value[n, k]['sigma']):.1f}" for k in ("cx", "cy"))]
        for n in numbers])
    rows.sort(key=lambda r: r[0])
    table(["pair", "orientation", "about x [°]", "y", "z", "less stated: x", "y", "z"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=ROOT.parent / "shared/data")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "build/real_pairs")
    parser.add_argument("--collinea", default=str(ROOT / "build/release/bin/collinea"))
    parser.add_argument("--only", default="27,ar,wall", help="some of these sets")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    program = Program(asked.collinea, asked.out.resolve())
    if "27" in asked.only:
        pair_27_28(program, asked.data / "film_pairs")
    if "ar" in asked.only:
        pair_ar112(program, asked.data / "film_pairs")
    if "wall" in asked.only:
        wall(program, asked.data / "wall_pair")


main()
