# SPDX-License-Identifier: Apache-2.0
"""COLMAP on the processor with its defaults, as the peer of the orientation benchmark, with a cache of its runs."""
import dataclasses
import json
import os
import shutil
import sqlite3

import measure

OFFSCREEN = {"QT_QPA_PLATFORM": "offscreen"}
STAGES = ("detect", "match", "orient")


@dataclasses.dataclass
class Run:
    costs: dict  # stage -> measure.Cost
    features: float  # mean of an image
    oriented: int  # images in the largest model
    models: int
    model: str  # folder of the largest model as text


def machine():
    with open("/proc/cpuinfo") as lines:
        names = [l.split(":")[1].strip() for l in lines if l.startswith("model name")]
    return f"{len(names)} x {names[0]}" if names else "unknown"


def features_of(database):
    with sqlite3.connect(database) as db:
        return db.execute("select avg(rows) from keypoints").fetchone()[0] or 0


def largest_model(sparse):
    """(number of models, images, text folder) of what the mapper wrote."""
    best, most = "", 0
    names = sorted(os.listdir(sparse))
    for name in names:
        text = os.path.join(sparse, name, "text")
        os.makedirs(text, exist_ok=True)
        measure.run(["colmap", "model_converter", "--input_path", os.path.join(sparse, name), "--output_path", text,
                     "--output_type", "TXT"], os.path.join(sparse, name, "log.txt"), OFFSCREEN)
        with open(os.path.join(text, "images.txt")) as lines:
            count = len([l for l in lines if not l.startswith("#")]) // 2
        if count > most:
            best, most = text, count
    return len(names), most, best


def run_once(images, camera_params, folder):
    """`camera_params`: fx,fy,cx,cy held fixed, or None for a single camera to be found (COLMAP's SIMPLE_RADIAL)."""
    shutil.rmtree(folder, ignore_errors=True)
    sparse = os.path.join(folder, "sparse")
    os.makedirs(sparse)
    database, log = os.path.join(folder, "database.db"), os.path.join(folder, "log.txt")
    known = ["--ImageReader.camera_model", "PINHOLE", "--ImageReader.camera_params", camera_params] if camera_params else []
    fixed = ["--Mapper.ba_refine_focal_length", "0", "--Mapper.ba_refine_extra_params", "0"] if camera_params else []
    words = {
        "detect": ["feature_extractor", "--database_path", database, "--image_path", images,
                   "--ImageReader.single_camera", "1", "--SiftExtraction.use_gpu", "0", *known],
        "match": ["exhaustive_matcher", "--database_path", database, "--SiftMatching.use_gpu", "0"],
        "orient": ["mapper", "--database_path", database, "--image_path", images, "--output_path", sparse, *fixed]}
    costs = {stage: measure.run(["colmap", *words[stage]], log, OFFSCREEN) for stage in STAGES}
    models, oriented, text = largest_model(sparse)
    return Run(costs, features_of(database), oriented, models, text)


def stored(run):
    return {**dataclasses.asdict(run), "machine": machine()}


def loaded(entry):
    costs = {stage: measure.Cost(**cost) for stage, cost in entry["costs"].items()}
    return Run(costs, entry["features"], entry["oriented"], entry["models"], entry["model"])


def runs(name, images, camera_params, repeats, out, cache):
    """`repeats` runs, as many of them as there are from the cache folder (only those of this kind of machine)."""
    folder = os.path.abspath(os.path.join(cache or out, "colmap-" + name))
    file = os.path.join(folder, "runs.json")
    entries = []
    if cache and os.path.exists(file):
        with open(file) as text:
            entries = [e for e in json.load(text) if e["machine"] == machine()]
    while len(entries) < repeats:
        entries.append(stored(run_once(images, camera_params, os.path.join(folder, str(len(entries))))))
        os.makedirs(folder, exist_ok=True)
        with open(file, "w") as text:
            json.dump(entries, text, indent=1)
    return [loaded(e) for e in entries[:repeats]]
