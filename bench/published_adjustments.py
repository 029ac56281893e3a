#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Adjusts the measurements of published adjustments and sets our results beside theirs.

usage: bench/published_adjustments.py [--data FOLDER] [--collinea PROGRAM] [--work FOLDER] [--rows]

--rows: as rows of the table of bench/adjustment instead.

DBAT (the Damped Bundle Adjustment Toolbox of Börlin and Grussenmeyer) publishes inputs and reports of its demos: sigma 0,
every camera parameter and orientation with its standard deviation. A row says by how much of a published standard
deviation our value differs at most, and between what ratios our standard deviations lie; published numbers have three
digits, which is 0.5 % of some of them: the last column counts those that are the same in every printed digit. Values that
are not differ by less than one unit of the last digit, because DBAT stops iterating at a relative step of 1e-6: its two
reports of the same adjustment, camcaldemo and camcal model3, differ from each other by as much. Inputs that are not in
the data folder are skipped. The exit code counts the cases whose values, standard deviations, sigma 0 or redundancy are not the
published ones within the bounds below, that hold something that is no number, or in which nothing could be compared.
"""
import argparse
import csv
import json
import math
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
WANTED_DIFFERENCE, WANTED_RATIO, WANTED_SIGMA0 = 0.02, 0.01, 1e-4


# --- what was published ----------------------------------------------------------------------------------------------

def numbers_after(text, name):
    return [float(value) for value in re.findall(name + r":\s+(-?[\d.]+(?:e[-+]?\d+)?)", text)]


def published(path):
    """sigma0, redundancy, camera {name: (value, sigma)}, images [[(value, sigma)] * 6], control {name: row}."""
    text = path.read_text(errors="replace")
    report = {"sigma0": numbers_after(text, "Sigma0")[0], "camera": {}, "images": [], "posterior": [], "exact": {}}
    found = re.search(r"Redundancy\s+(\d+)", text)
    for file in path.parent.glob("*.xml"):  # the camera with all digits
        exact = file.read_text()
        for tag, named in {"cc": ["cc"], "pp": ["px", "py"], "K": ["K1", "K2", "K3"], "P": ["P1", "P2"]}.items():
            report["exact"].update(zip(named, re.search(f"<{tag}>(.*?)</{tag}>", exact)[1].split(",")))
    report["redundancy"] = int(found[1]) if found else None
    names = {"Camera Constant": "cc", "px - ": "px", "py - ": "py", "K1 - ": "K1", "K2 - ": "K2", "K3 - ": "K3",
             "P1 - ": "P1", "P2 - ": "P2", "as - ": "as"}
    cameras, photos = text.split("Photograph Standard Deviations")
    for title, name in names.items():
        found = re.search(re.escape(title) + r"[^\n]*\n\s+Value:\s+(\S+)[^\n]*(?:\n\s+Deviation:\s+(\S+))?", cameras)
        if found:
            report["camera"][name] = (float(report["exact"].get(name, found[1])), float(found[2]) if found[2] else 0)
    for block in re.split(r"\n\s+Photo \d+: ", photos.split("\n   Quality")[0])[1:]:
        image = []
        for name in ["Omega", "Phi", "Kappa", "Xc", "Yc", "Zc"]:
            found = re.search(name + r":\n\s+Value:\s+(\S+)[^\n]*(?:\n\s+Deviation:\s+(\S+))?", block)
            image.append((found[1], float(found[2]) if found[2] else 0))
        report["images"].append((block.split("\n")[0].strip(), image))
    found = re.search(r"Posterior\n[^\n]*\n(.*?)\n\s+Diff", text, re.S)
    if found:
        for line in found[1].split("\n"):
            fields = [field.strip() for field in line.split(",")]
            report["posterior"].append((fields[0], fields[8], fields[1:7]))
    return report


# --- ours ------------------------------------------------------------------------------------------------------------

def adjusted(program, source, folder, *options):
    done = subprocess.run([program, "adjust", "--import", source, "--output", folder, "--loss", "none", "--progress",
                           "lines", *options], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{source}: {done.stderr}")
    ours = json.loads((folder / "adjustment.json").read_text())
    with open(folder / "poses.csv") as file:
        ours["images"] = {row["image"]: row for row in csv.DictReader(file)}
    with open(folder / "control.csv") as file:
        ours["control"] = {row["point"]: row for row in csv.DictReader(file)}
    return ours


def camera_in_mm(camera, pixel_height_mm):
    """{name: (value, sigma)} as DBAT writes it, standard deviations by propagation of ours with their correlations."""
    parameters = camera["parameters"]
    names = list(parameters)
    values = [parameters[name]["value"] for name in names]
    sigmas = [parameters[name].get("sigma", 0) for name in names]

    def covariance(i, j):
        if i == j:
            return sigmas[i] ** 2
        a, b = names[max(i, j)], names[min(i, j)]
        return sigmas[i] * sigmas[j] * camera.get("correlations", {}).get(a, {}).get(b, 0)

    sign = -1 if camera["model"] == "brown" else 1

    def convert(v):
        p = dict(zip(names, v))
        c = p["f"] * pixel_height_mm
        return {"cc": c, "px": p["cx"] * pixel_height_mm, "py": p["cy"] * pixel_height_mm,
                "as": -p["b1"] / (p["f"] + p["b1"]), "K1": sign * p["k1"] / c**2, "K2": sign * p["k2"] / c**4,
                "K3": sign * p["k3"] / c**6, "P1": sign * p["p1"] / c, "P2": -sign * p["p2"] / c}

    at = convert(values)
    gradient = {name: [] for name in at}
    for i, value in enumerate(values):
        step = 1e-6 * max(abs(value), 1e-3)
        plus, minus = (convert(values[:i] + [value + s] + values[i + 1:]) for s in (step, -step))
        for name in at:
            gradient[name].append((plus[name] - minus[name]) / (2 * step))
    variance = {name: sum(g[i] * g[j] * covariance(i, j) for i in range(len(g)) for j in range(len(g)))
                for name, g in gradient.items()}
    return {name: (at[name], math.sqrt(max(0, variance[name]))) for name in at}


class Comparison:
    """Differences in published sigmas, ratios of standard deviations, and values that differ in a printed digit."""

    def __init__(self):
        self.worst, self.least, self.most = (0, ""), (9, ""), (0, "")
        self.printed, self.digits, self.sigma_digits, self.numbers = 0, 0, 0, True

    def add(self, name, ours, sigma, text, their_sigma):
        if not their_sigma:
            return
        their = float(text)
        self.numbers = self.numbers and math.isfinite(ours) and math.isfinite(sigma)
        difference = abs(ours - their)
        if name.split()[-1] in ("Omega", "Phi", "Kappa"):
            difference = min(difference % 360, -difference % 360)
        self.worst = max(self.worst, (difference / their_sigma, name))
        self.least = min(self.least, (sigma / their_sigma, name))
        self.most = max(self.most, (sigma / their_sigma, name))
        self.sigma_digits += float(f"{sigma:.3g}") == their_sigma
        if isinstance(text, str) and "." in text:
            self.printed += 1
            last = 10.0 ** -len(text.split(".")[1])
            self.digits += difference <= 0.5 * last * (1 + 1e-6)


def compare(ours, theirs, pixel_height_mm):
    camera, images = Comparison(), Comparison()
    if theirs["camera"]:
        mine = camera_in_mm(ours["cameras"][0], pixel_height_mm)
        for name, (value, sigma) in theirs["camera"].items():
            camera.add(name, *mine[name], value, sigma)
    for name, image in theirs["images"]:
        row = ours["images"][name]
        for (text, sigma), title, mine in zip(image, ["Omega", "Phi", "Kappa", "X", "Y", "Z"],
                                             ["omega_deg", "phi_deg", "kappa_deg", "x_m", "y_m", "z_m"]):
            if sigma:
                images.add(f"{name} {title}", float(row[mine]), float(row["sigma_" + mine]), text, sigma)
    return camera, images


def agrees(comparison):
    return comparison.numbers and (not comparison.worst[1] or (
        comparison.worst[0] <= WANTED_DIFFERENCE and comparison.most[0] <= 1 + WANTED_RATIO and
        comparison.least[0] >= 1 - WANTED_RATIO))


def same_fit(ours, theirs):
    """sigma0 to the published digits, and the redundancy where it was published."""
    return (abs(ours["sigma0"] / theirs["sigma0"] - 1) <= WANTED_SIGMA0 and
            theirs["redundancy"] in (None, ours["redundancy"]))


def shown(comparison):
    if not comparison.worst[1]:
        return f"{'':^28}"
    return f"{comparison.worst[0]:8.4f} {comparison.least[0]:9.4f} {comparison.most[0]:9.4f}"


# --- the cases -------------------------------------------------------------------------------------------------------

def with_control(text, rows):
    """The exchange file with other control: rows {name: (x, y, z, sigma)}."""
    kept = []
    for line in text.split("\n"):
        words = line.split()
        if words[:1] == ["measured_tie"] and words[2] in rows:
            line = line.replace("measured_tie", "measured_control", 1)
        if words[:1] != ["control"] and not (words[:1] == ["point"] and words[1] in rows):
            kept.append(line)
    return "\n".join(kept + [f"control {name} {x} {y} {z} {s} {s} {s}" for name, (x, y, z, s) in rows.items()]) + "\n"


def with_lens(text, model, free):
    """The exchange file with another lens: only the parameters `free` are, from values of no lens."""
    out = []
    for line in text.split("\n"):
        if line.startswith("camera "):
            line = re.sub(r" brown_of_measured.*", " " + model, line)
        found = re.match(r"(parameter \S+) (\S+) (\S+) ", line)
        if found:
            value = found[3] if found[2] in ("f", "cx", "cy") else "0"
            line = f"{found[1]} {found[2]} {value} {'free' if found[2] in free else 'fixed'}"
        out.append(line)
    return "\n".join(out)


def control_rows(path):
    rows = {}
    for line in path.read_text().split("\n"):
        fields = [field.strip() for field in line.split(",")]
        if len(fields) >= 5 and not line.startswith("#"):
            rows[fields[0]] = (*map(float, fields[2:5]), float((fields + ["0"])[5]))
    return rows


def cases(data, work, program):
    """(name, file to import, published report, height of a pixel [mm])."""
    script = data / "script"
    yield "camcaldemo", script / "camcaldemo/camcaldemo.xml", script / "camcaldemo/result/report.txt", 5.43764 / 1704
    yield ("romabundledemo", script / "romabundledemo/romabundledemo.xml",
           script / "romabundledemo/result/report.txt", 24 / 3744)
    corrections = "brown_of_measured sigmas_after_correction"
    free = ["f", "cx", "cy", "k1", "k2", "k3", "p1", "p2"]
    source = data / "dbat/pmexports/camcal-pmexport.txt"
    for name, model, parameters in [("model1", corrections, free), ("model3", corrections, free + ["b1"]),
                                    ("model-1", "brown", free)]:
        converted = work / f"camcal-{name}.txt"
        if source.exists():
            subprocess.run([program, "adjust", "--import", source, "--export", converted, "--progress", "none"],
                           check=True, capture_output=True)
            text = with_control(converted.read_text(), control_rows(data / "dbat/ref/camcal-fixed.txt"))
            converted.write_text(with_lens(text, model, parameters))
        yield f"camcal {name}", converted, data / f"dbat/dbatexports/camcal-dbatreport-{name}.txt", 5.43764 / 1704
    prague = data / "prague2016/cam"
    for kind in ["fixed", "weighted"]:
        for orient in ["", "-no-orient", "-with-orient"]:
            source = prague / f"pmexports/{kind}{orient or '-no-orient'}-pmexport.txt"
            converted = work / f"prague-{kind}{orient}.txt"
            if source.exists():
                subprocess.run([program, "adjust", "--import", source, "--export", converted, "--progress", "none"],
                               check=True, capture_output=True)
                # DBAT shifts the control it loads by the difference of means to that of PhotoModeler's project.
                text = converted.read_text()
                there = [line.split()[2:5] for line in text.split("\n") if line.startswith("control ")]
                rows = control_rows(prague / f"ref/ctrlpts-{kind}.txt")
                shift = [(sum(float(row[i]) for row in there) - sum(row[i] for row in rows.values())) / len(rows)
                         for i in range(3)]
                rows = {name: (*(row[i] + shift[i] for i in range(3)), row[3]) for name, row in rows.items()}
                converted.write_text(with_control(text, rows))
            yield (f"prague2016 {kind}{orient}", converted,
                   prague / f"dbatexports/{kind}{orient}-dbatreport.txt", 5.4399 / 1704)


def as_row(what, must, measured, ok):
    return f"| {what} | {must} | {measured} | {'yes' if ok else 'NO'} |"


def rows_skipped(what, missing):
    return as_row(what, "the data", f"skipped: no {missing}", False)


def line_of(*words):
    return " ".join(str(word) for word in words) + "\n"


def exercises(data, work, program, rows):
    """Intersection and resection of the exercises of the University of Cape Town, beside the corrected results."""
    if not data.exists():
        print(rows_skipped("collinearity_exercises", data) if rows else f"exercises skipped: no {data}")
        return 0
    focal_px = 8.865 / 0.00241
    head = line_of("collinea-adjustment", 1) + line_of("camera", "c", 5472, 3648, "brown")
    for name, value in {"f": focal_px, "cx": 2737.24, "cy": 1839.91}.items():
        head += line_of("parameter", "c", name, value, "fixed")
    failed = 0

    def show(name, ours, expected, digits):
        nonlocal failed
        agree = all(abs(a - b) <= 0.5 * 10.0 ** -d for a, b, d in zip(ours, expected, digits))
        failed += not agree
        if rows:
            print(as_row(f"collinearity_exercises: {name}", "the corrected results of its README, every digit",
                         " ".join(f"{value:.3f}" for value in ours), agree))
            return
        print(f"{name:28} {' '.join(f'{value:.3f}' for value in ours)}   corrected result "
              f"{' '.join(map(str, expected))}: {'the same digits' if agree else 'DIFFERENT'}")

    for images in (2, 3, 4):
        text = head
        for line in (data / f"inter/inputInter0{images}.txt").read_text().split("\n")[1:]:
            words = line.split()
            if len(words) >= 9:
                text += line_of("image", words[0], "c") + line_of("pose", words[0], *words[3:9], "fixed")
                text += line_of("measured_tie", words[0], 9, words[1], -float(words[2]), 1)
        file = work / f"intersection-{images}.txt"
        file.write_text(text)
        adjusted(program, file, work / file.stem)
        with open(work / file.stem / "points.csv") as table:
            row = next(csv.DictReader(table))
        point = [float(row[f"{axis}_in_world_m"]) for axis in "xyz"]
        surveyed = (265516.276, 6239996.187, 87.62)
        if images == 2:
            show("intersection of 2 images", point, (265516.57, 6239995.97, 87.69), (2, 2, 2))
        elif not rows:
            away = " ".join(f"{a - b:.3f}" for a, b in zip(point, surveyed))
            print(f"{f'intersection of {images} images':28} {' '.join(f'{v:.3f}' for v in point)}   from the survey {away}")
    text = head + line_of("image", "DJI_0121", "c")
    for line in (data / "resec/resecResc121.inp").read_text().split("\n"):
        words = line.split()
        if len(words) == 6:
            text += line_of("control", words[0], *words[3:], 0, 0, 0)
            text += line_of("measured_control", "DJI_0121", *words[:3], 1)
    file = work / "resection.txt"
    file.write_text(text)
    row = adjusted(program, file, work / "resection")["images"]["DJI_0121"]
    show("resection of DJI_0121", [float(row[k]) for k in ("omega_deg", "phi_deg", "kappa_deg", "x_m", "y_m", "z_m")],
         (-10.731, 0.324, -177.159, -49652.05, -3758661.01, 140.36), (3, 3, 3, 2, 2, 2))
    return failed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=pathlib.Path, default=ROOT.parent / "shared/data/dbat_text")
    parser.add_argument("--collinea", default=ROOT / "build/release/bin/collinea")
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("/tmp/published_adjustments"))
    parser.add_argument("--rows", action="store_true")
    asked = parser.parse_args()
    asked.work.mkdir(parents=True, exist_ok=True)
    asked.rows or print(f"{'':28} {'sigma0':>17} {'redundancy':>15} | camera: {'differ':>6} {'ratio of std devs':>19} | "
          f"images: {'differ':>6} {'ratio of std devs':>19} | printed digits: values, std devs")
    failed = 0
    for name, source, report, pixel in cases(asked.data, asked.work, asked.collinea):
        if not source.exists() or not report.exists():
            missing = source if not source.exists() else report
            print(rows_skipped(name, missing) if asked.rows else f"{name:28} skipped: no {missing}")
            continue
        theirs, ours = published(report), adjusted(asked.collinea, source, asked.work / name.replace(" ", "-"))
        camera, images = compare(ours, theirs, pixel)
        compared = [one for one in (camera, images) if one.worst[1]]
        wrong = not (compared and agrees(camera) and agrees(images) and same_fit(ours, theirs))
        if asked.rows and name.startswith("prague2016"):
            wrong |= images.digits < images.printed
        failed += bool(wrong)
        if asked.rows:
            differ = max((one.worst[0] for one in compared), default=math.nan)
            ratios = "nothing"
            if compared:
                ratios = f"{min(one.least[0] for one in compared):.4f} to {max(one.most[0] for one in compared):.4f}"
            must = "parameters within 0.02 sigma, standard deviations within 1 %"
            if name.startswith("prague2016"):
                must += ", every printed digit"
            print(as_row(f"published: {name}", must,
                         f"sigma0 {ours['sigma0']:.6g}, published {theirs['sigma0']:.6g}; differ by {differ:.4f} sigma; "
                         f"standard deviations {ratios} of theirs; {images.digits} of {images.printed} printed values "
                         "the same", not wrong))
            continue
        print(f"{name:28} {ours['sigma0']:8.6g} {theirs['sigma0']:8.6g} {ours['redundancy']:7} "
              f"{theirs['redundancy'] or '':>7} | {shown(camera)}  | {shown(images)}  | "
              f"{images.digits} and {images.sigma_digits} of {images.printed}")
    return failed + exercises(asked.data.parent / "collinearity_exercises/data", asked.work, asked.collinea, asked.rows)


if __name__ == "__main__":
    sys.exit(main())
