#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Do two builds of the program make the same products, bit for bit, at the same cost?

usage: bench/same_bits.py hash --collinea PROGRAM --work DIR --out F.json [--only NAME ...] [--threads N] [--repeat N] [--data DIR]
       bench/same_bits.py compare BEFORE.json AFTER.json [--meant PATTERN ...] [--all]
`hash` runs all steps on the blocks demo (rendered anew), brighton_beach, fountain-P11, sheffield_cross and odm_copr, exports of each
oriented block and a few commands on it. It writes hashes of what was made and what each step cost to F.json; blocks that
another call wrote there stay. Projects stay in DIR.
  --only    blocks; default: all. Those whose data are missing are skipped, saying so
  --threads processor threads, default 2
  --repeat  runs of each block: all must make the same; the least cost of each step is written
  --data    folder of the real blocks (default ../shared/data)
`compare` prints a row for each product and step, and ends with exit code 1 when a product is different or gone, or is made by
one build alone. Of numbers in the project's database that have gone, and of figures and words in reports, it tells without a
verdict: its tables and their words may change while the products do not.
  --meant   differences of products that match this shell pattern (BLOCK/PRODUCT) are no failure
  --all     prints the same products one by one, too
What is hashed: of rasters pixels and tags (size, georeference, metadata), of clouds the bytes, of GeoPackages the rows, of other
files the bytes; always without version and date of writing.
"""
import argparse
import fnmatch
import hashlib
import json
import os
import re
import shutil
import sqlite3
import struct
import subprocess
import sys
import zlib

import measure

VERSION = re.compile(rb"collinea v?\d+\.\d+[\w.+-]*")


def digest(pieces):
    total = hashlib.sha256()
    for piece in pieces:
        total.update(piece)
    return total.hexdigest()[:32]


def unversioned(data):
    return VERSION.sub(b"collinea", data)


# Rasters

TIFF_SIZES = {1: 1, 2: 1, 3: 2, 4: 4, 5: 8, 6: 1, 7: 1, 8: 2, 9: 4, 10: 8, 11: 4, 12: 8, 13: 4, 16: 8, 17: 8, 18: 8}
TIFF_OFFSETS, TIFF_COUNTS = (273, 324), (279, 325)
TIFF_SOFTWARE_DATE = (305, 306)
TIFF_COMPRESSION, TIFF_DEFLATE = 259, (8, 32946)


def tiff_directories(data):
    """Of each image in the file, {tag: (type, count, bytes of the value)}."""
    order = "<" if data[:2] == b"II" else ">"
    big = struct.unpack_from(order + "H", data, 2)[0] == 43
    head, entry, word = ("Q", "HHQ", "Q") if big else ("H", "HHI", "I")
    at = struct.unpack_from(order + word, data, 8 if big else 4)[0]
    while at:
        tags, entries = {}, struct.unpack_from(order + head, data, at)[0]
        at += struct.calcsize(order + head)
        for _ in range(entries):
            tag, kind, count = struct.unpack_from(order + entry, data, at)
            at += struct.calcsize(order + entry)
            size, start = TIFF_SIZES[kind] * count, at
            if size > struct.calcsize(order + word):
                start = struct.unpack_from(order + word, data, at)[0]
            tags[tag] = (kind, count, data[start:start + size])
            at += struct.calcsize(order + word)
        yield order, tags
        at = struct.unpack_from(order + word, data, at)[0]


def tiff_numbers(order, value):
    kind, count, data = value
    return struct.unpack(f"{order}{count}{ {3: 'H', 4: 'I', 16: 'Q'}[kind] }", data)


def raster_parts(file):
    """Pixels are taken as they come out of deflate, still as differences to their neighbours; tags tell of those."""
    with open(file, "rb") as opened:
        data = opened.read()
    pixels, tags = hashlib.sha256(), hashlib.sha256()
    for order, directory in tiff_directories(data):
        compression = tiff_numbers(order, directory[TIFF_COMPRESSION])[0]
        for offsets, counts in zip(TIFF_OFFSETS, TIFF_COUNTS):
            if offsets in directory:
                for start, size in zip(tiff_numbers(order, directory[offsets]), tiff_numbers(order, directory[counts])):
                    tile = data[start:start + size]
                    pixels.update(zlib.decompress(tile) if size and compression in TIFF_DEFLATE else tile)
        for tag, (kind, _, value) in sorted(directory.items()):
            if tag not in TIFF_OFFSETS + TIFF_COUNTS + TIFF_SOFTWARE_DATE:
                tags.update(f"{tag} {kind} ".encode() + unversioned(value))
    return {"pixels": pixels.hexdigest()[:32], "tags": tags.hexdigest()[:32]}


# Clouds, drawings, texts


def cloud_parts(file):
    """A LAS, LAZ or COPC file without its program (32 bytes), day and year of writing."""
    with open(file, "rb") as opened:
        data = bytearray(opened.read())
    data[58:94] = bytes(36)
    return {"bytes": digest([data])}


def bytes_parts(file):
    with open(file, "rb") as opened:
        data = opened.read()
    return {"bytes": digest([unversioned(data[:4096]), data[4096:]])}


def database(file):
    return sqlite3.connect("file:" + file + "?mode=ro", uri=True)


def columns_of(db, table):
    """Names, declared types, and the columns that bring rows into a defined order."""
    rows = db.execute(f'PRAGMA table_info("{table}")').fetchall()
    keys = [f'"{r[1]}"' for r in sorted(rows, key=lambda r: r[5]) if r[5]]
    return {r[1]: r[2].upper() for r in rows}, ", ".join(keys) or "rowid"


def tables_of(db):
    rows = db.execute("SELECT name, sql FROM sqlite_master WHERE type = 'table' ORDER BY name").fetchall()
    return [name for name, sql in rows if "VIRTUAL" not in sql.upper() and not name.startswith(("rtree_", "sqlite_"))]


def column_digest(db, table, column, order):
    values = (value for value, in db.execute(f'SELECT "{column}" FROM "{table}" ORDER BY {order}'))
    return digest(type(v).__name__.encode() + b" " + (v if isinstance(v, bytes) else str(v).encode()) + b"\n" for v in values)


def geopackage_parts(file):
    db, parts = database(file), {}
    for table in tables_of(db):
        columns, order = columns_of(db, table)
        parts[table] = digest(f"{c} {column_digest(db, table, c, order)}\n".encode() for c in columns if c != "last_change")
    db.close()
    return parts


def file_parts(file):
    """Hashes of the parts of a file by their names."""
    ending = os.path.splitext(file)[1].lower()
    if ending in (".tif", ".tiff"):
        return raster_parts(file)
    if ending in (".las", ".laz"):
        return cloud_parts(file)
    if ending == ".gpkg":
        return geopackage_parts(file)
    return bytes_parts(file)


# What a project holds

COST_COLUMN, HASH_COLUMNS = "cpu_seconds", ("inputs_hash", "output_hash")


def database_columns(file):
    """Hashes of each column by TABLE.COLUMN, but for words, hashes of options and tables of what steps cost."""
    db, found = database(file), {}
    for table in tables_of(db):
        columns, order = columns_of(db, table)
        for column, kind in columns.items():
            if COST_COLUMN not in columns and column not in HASH_COLUMNS and kind != "TEXT":
                found[f"{table}.{column}"] = column_digest(db, table, column, order)
    db.close()
    return found


MOST_FIGURES = 20000


def figures(file):
    """The decimal numbers that a text holds, each once and without its sign: they stay when its keys and words are changed.
    Of many, one hash of them all."""
    with open(file, encoding="utf-8", errors="replace") as text:
        found = re.findall(r"\d+\.\d+(?:[eE][-+]?\d+)?", text.read())
    unlike = sorted({repr(float(f)) for f in found})
    return unlike if len(unlike) <= MOST_FIGURES else [f"all {len(unlike)}: " + digest(f"{f}\n".encode() for f in unlike)]


def files_below(folder):
    found = []
    for place, folders, names in os.walk(folder):
        folders.sort()
        found += [os.path.relpath(os.path.join(place, name), folder) for name in sorted(names)]
    return found


REPORTS = (".json", ".html", ".csv", ".txt")


def take_stock(top, wanted, files, texts):
    """Adds what lies in the folders `wanted` of `top`: hashes of products, figures of reports."""
    for folder in wanted:
        for name in files_below(os.path.join(top, folder)):
            path, key = os.path.join(top, folder, name), f"{folder}/{name}"
            in_report = folder.endswith(("report", "adjustment")) or folder.startswith("commands")
            if in_report and name.endswith(REPORTS):
                if not name.endswith(".html"):
                    texts[key] = figures(path)
            elif not (folder.endswith("depth") and name.endswith("inputs.txt")):
                files[key] = file_parts(path)


# Running

root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def blocks(data):
    """Folder of photographs, options of the run and data that must be there, by the name of the block; DEMO is what is rendered."""
    sheffield, fountain = os.path.join(data, "sheffield_cross"), os.path.join(data, "strecha2008", "fountain-P11")
    return {
        "demo": ("DEMO/images", ["--control", "DEMO/control.csv"]),
        "brighton_beach": (os.path.join(data, "brighton_beach", "images"), []),
        "fountain-P11": (os.path.join(fountain, "images"), []),
        "sheffield_cross": (os.path.join(sheffield, "images"),
                            ["--control", os.path.join(sheffield, "gcp_list.txt"), "--check", "gcp2,gcp4"]),
        "odm_copr": (os.path.join(data, "odm_copr", "images"), ["--control", os.path.join(data, "odm_copr", "gcp_list.txt")]),
    }


EXPORTS = {"colmap", "opk", "bundler", "ply"}
CLOUD_EXPORTS = {"laz", "copc"}  # of the smallest block alone


def step_costs(program, project):
    steps = json.loads(subprocess.check_output([program, "info", project, "--json"]))["steps"]
    return {s["name"]: {"seconds": s["seconds"], "cpu_seconds": s["cpu_seconds"], "peak_mb": s["peak_memory_bytes"] / 1e6}
            for s in steps}


def as_step(cost):
    return {"seconds": cost.wall_s, "cpu_seconds": cost.cpu_s, "peak_mb": cost.peak_bytes / 1e6}


def run_block(args, name, photos, options):
    """All steps, exports and commands on a block. Returns hashes, figures and costs."""
    top = os.path.join(args.work, name)
    shutil.rmtree(top, ignore_errors=True)
    os.makedirs(top)
    log, project, rendered, costs = os.path.join(top, "run.log"), os.path.join(top, "project"), os.path.join(top, "block"), {}

    def collinea(*words):
        return measure.run([args.collinea, *words], log)

    def attempt(*words):
        """Like collinea(), but who cannot do it goes on without its products: the other build must not be able, either."""
        try:
            return collinea(*words)
        except SystemExit as failure:
            print(f"{name}: {failure}", flush=True)
            return measure.Cost()

    threads = ["--threads", args.threads]
    wanted = ["project/products", "project/depth", "project/report"]
    if name == "demo":
        costs["simulate"] = as_step(collinea("simulate", rendered, *threads))
        wanted.append("block")
    photos, *options = [word.replace("DEMO", rendered) for word in [photos, *options]]
    collinea("run", photos, "-o", project, *threads, "--progress", "lines", *options)
    costs.update(step_costs(args.collinea, project))
    columns = database_columns(os.path.join(project, "block.db"))
    for form in sorted(EXPORTS | (CLOUD_EXPORTS if name == "brighton_beach" else set())):
        attempt("export", project, os.path.join(top, "export", form), "--format", form, *threads)
    wanted.append("export")
    wanted.append("project/adjustment")
    first, second = sorted(os.listdir(photos))[:2]
    commands = os.path.join(top, "commands")
    costs["adjust --output"] = as_step(attempt("adjust", project, "--output", os.path.join(commands, "adjust"), *threads))
    costs["stereo"] = as_step(attempt("stereo", os.path.join(photos, first), os.path.join(photos, second), "--project", project,
                                      "-o", os.path.join(commands, "stereo"), *threads))
    wanted.append("commands")
    files, texts = {}, {}
    take_stock(top, wanted, files, texts)
    return {"files": files, "database": columns, "figures": texts, "steps": costs}


def least_costs(runs):
    return {step: {what: min(r["steps"][step][what] for r in runs) for what in cost} for step, cost in runs[0]["steps"].items()}


def hash_blocks(args):
    known, unstable = blocks(args.data), False
    if unknown := set(args.only) - set(known):
        sys.exit(f"no such block: {', '.join(sorted(unknown))}")
    for name in args.only or known:
        photos, options = known[name]
        if name != "demo" and not os.path.isdir(photos):
            print(f"{name}: skipped, no {photos}")
            continue
        runs = [run_block(args, name, photos, options) for _ in range(args.repeat)]
        for again in runs[1:]:
            for key in ("files", "database"):
                for product in sorted(set(runs[0][key]) | set(again[key])):
                    if runs[0][key].get(product) != again[key].get(product):
                        print(f"DIFFERENT from run to run: {name}/{product}")
                        unstable = True
        written = {}
        if os.path.exists(args.out):
            with open(args.out) as file:
                written = json.load(file)
        written[name] = {**runs[0], "steps": least_costs(runs), "threads": args.threads}
        with open(args.out + ".part", "w") as file:
            json.dump(written, file, indent=1)
        os.replace(args.out + ".part", args.out)
        seconds = sum(s["seconds"] for s in runs[0]["steps"].values())
        print(f"{name}: {len(runs[0]['files'])} files, {len(runs[0]['database'])} columns of the database, {seconds:.0f} s", flush=True)
    return unstable


# Comparing


def verdict(before, after):
    """`same`, `DIFFERENT` with the parts that are, `gone` or `new`."""
    if before is None or after is None:
        return "new" if before is None else "gone"
    if before == after:
        return "same"
    if isinstance(before, str):
        return "DIFFERENT"
    return "DIFFERENT: " + ", ".join(p for p in sorted(set(before) | set(after)) if before.get(p) != after.get(p))


def compare_products(args, block, before, after):
    """Prints a row for each product and returns the number of failures."""
    failures, same = 0, {}
    for kind in ("files", "database"):
        for product in sorted(set(before[kind]) | set(after[kind])):
            shown = product if kind == "files" else "block.db: " + product
            found = verdict(before[kind].get(product), after[kind].get(product))
            if found == "same" and not args.all:
                folder = os.path.dirname(product) if kind == "files" else "block.db"
                same.setdefault(folder, []).append(os.path.basename(product))
                continue
            failure = found.startswith("DIFFERENT") or (kind == "files" and found != "same")
            if failure and any(fnmatch.fnmatch(f"{block}/{product}", p) for p in args.meant):
                failure, found = False, found + " (meant)"
            failures += failure
            measure.row(block, shown, found)
    for folder, names in sorted(same.items()):
        listed = ", ".join(names) if len(names) <= 20 else f"{len(names)} of them"
        measure.row(block, f"{folder}: {listed}", "same")
    for text in sorted(set(before["figures"]) | set(after["figures"])):
        old, new = ({f.lstrip("-") for f in side["figures"].get(text, [])} for side in (before, after))
        if old - new:
            examples = ", ".join(sorted(old - new)[:3])
            measure.row(block, f"{text}: {len(old)} figures", f"{len(old - new)} no longer there: {examples} (no verdict)")
    return failures


NOISE = {"cpu_seconds": 0.05, "peak_mb": 3}  # no verdict on less than that; a busy machine makes more, see --repeat


def compare_costs(block, before, after):
    for step, old in before["steps"].items():
        new = after["steps"].get(step)
        if not new:
            measure.row(block, step, "gone", "", "", "")
            continue
        ratios = {what: new[what] / old[what] if old[what] else 1 for what in old}
        slower, larger = (ratios[what] > 1.03 and new[what] - old[what] > NOISE[what] for what in ("cpu_seconds", "peak_mb"))
        measure.row(block, step, *(f"{old[w]:.2f} -> {new[w]:.2f} ({ratios[w]:.3f})" for w in ("seconds", "cpu_seconds")),
                    f"{old['peak_mb']:.0f} -> {new['peak_mb']:.0f} ({ratios['peak_mb']:.3f})",
                    " ".join(w for w, is_so in (("slower", slower), ("larger", larger)) if is_so) or "-")


def compare(args):
    with open(args.before) as first, open(args.after) as second:
        before, after = json.load(first), json.load(second)
    both = [block for block in before if block in after]
    measure.head("block", "product", "verdict")
    failures = sum(compare_products(args, block, before[block], after[block]) for block in both)
    print()
    measure.head("block", "step", "seconds", "CPU seconds", "peak [MB]", "by more than 3 %")
    for block in both:
        compare_costs(block, before[block], after[block])
    print(f"\n{failures} products differ; blocks compared: {', '.join(both) or 'none'}"
          + "".join(f"; {b} was not run by both" for b in sorted(set(before) ^ set(after))))
    return failures or not both


def main():
    parser = argparse.ArgumentParser()
    commands = parser.add_subparsers(dest="command", required=True)
    one = commands.add_parser("hash")
    one.add_argument("--collinea", default=os.path.join(root, "build", "release", "bin", "collinea"))
    one.add_argument("--work", default=os.path.join(root, "build", "bench-same-bits"))
    one.add_argument("--out", required=True)
    one.add_argument("--only", nargs="+", default=[])
    one.add_argument("--threads", type=int, default=2)
    one.add_argument("--repeat", type=int, default=1)
    one.add_argument("--data", default=os.path.join(os.path.dirname(root), "shared", "data"))
    two = commands.add_parser("compare")
    two.add_argument("before")
    two.add_argument("after")
    two.add_argument("--meant", nargs="+", default=[])
    two.add_argument("--all", action="store_true")
    args = parser.parse_args()
    sys.exit(bool(hash_blocks(args) if args.command == "hash" else compare(args)))


if __name__ == "__main__":
    main()
