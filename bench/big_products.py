#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A project with large products, for bench/page_big.mjs: a cloud sorted by our own writer, and an orthophoto.

usage: bench/big_products.py FOLDER [--points 100000000] [--pixels 45000] [--collinea PROGRAM]
FOLDER/project becomes a block of 12 simulated images with products/cloud.copc.laz and products/ortho.tif. Made-up heights
and colours: hills with roads and roofs, so that both compress about as products of photographs do. Wants numpy and osgeo,
four bytes of disk for ten of cloud meanwhile, and some ten minutes.
"""
import argparse
import os
import struct
import subprocess
import sys

import numpy as np

root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
parser = argparse.ArgumentParser()
parser.add_argument("folder")
parser.add_argument("--points", type=int, default=100_000_000)
parser.add_argument("--pixels", type=int, default=45_000)
parser.add_argument("--collinea", default=os.path.join(root, "build", "release", "bin", "collinea"))
args = parser.parse_args()
project = os.path.join(args.folder, "project")
products = os.path.join(project, "products")
SIDE = 2250.0  # m
EAST, NORTH = 546_812.0 - SIDE / 2, 5_338_721.0 - SIDE / 2  # about the simulated block (EPSG:32633)


def collinea(*words):
    done = subprocess.run([args.collinea, *map(str, words)])
    if done.returncode:
        sys.exit(f"FAILED ({done.returncode}): collinea {' '.join(map(str, words))}")


def heights(x, y):
    hills = 40 * np.sin(x / 310) * np.cos(y / 270) + 6 * np.sin(x / 37 + y / 53)
    roofs = 7 * ((np.sin(x / 9) > 0.7) & (np.sin(y / 11) > 0.6))
    return 300 + hills + roofs


def colours(x, y, random):
    base = 110 + 50 * np.sin(x / 23) * np.sin(y / 31) + random.normal(0, 9, x.shape)
    roof = (np.sin(x / 9) > 0.7) & (np.sin(y / 11) > 0.6)
    return [np.clip(base + shift + 60 * on * roof, 0, 255).astype(np.uint8) for shift, on in ((0, 1), (12, 0), (-15, 0))]


RECORD = np.dtype([("xyz", "<i4", 3), ("intensity", "<u2"), ("returns", "u1"), ("flags", "u1"), ("class", "u1"), ("user", "u1"),
                   ("angle", "<i2"), ("source", "<u2"), ("time", "<f8"), ("rgb", "<u2", 3), ("sigma", "<f4"), ("images", "u1")])


def descriptor(kind, name):
    return struct.pack("<HBB32s4s120s32s", 0, kind, 0, name, b"", b"", b"")


def write_las(path):
    """LAS 1.4, point format 7, with the extra bytes that our clouds have; in strips from south to north, as depth maps come."""
    record = descriptor(9, b"sigma_m") + descriptor(1, b"images")
    head = struct.pack("<H16sHH32s", 0, b"LASF_Spec", 4, len(record), b"") + record
    scale, offset = 0.001, (EAST, NORTH, 300.0)
    header = struct.pack("<4sHH16sBB32s32sHHHIIBH24s", b"LASF", 0, 16, b"", 1, 4, b"", b"bench", 0, 0, 375, 375 + len(head), 1, 7, RECORD.itemsize, b"")
    header += struct.pack("<6d", scale, scale, scale, *offset)
    header += struct.pack("<6d", EAST + SIDE, EAST, NORTH + SIDE, NORTH, 360.0, 240.0)
    header += struct.pack("<QQIQQ112s", 0, 0, 0, args.points, args.points, b"")
    random = np.random.default_rng(1)
    pieces = -(-args.points // 1_000_000)
    with open(path, "wb") as file:
        file.write(header + head)
        for piece in range(pieces):
            count = min(1_000_000, args.points - piece * 1_000_000)
            x = SIDE * random.random(count)
            y = SIDE * (piece + random.random(count)) / pieces
            points = np.zeros(count, RECORD)
            sigma = 0.02 + 0.05 * random.random(count) ** 4
            z = heights(x, y) + sigma * random.normal(0, 1, count)
            points["xyz"] = np.round(np.stack([x, y, z - 300], axis=1) / scale)
            points["returns"] = 0x11
            points["class"] = np.where(np.sin(x / 9) > 0.7, 6, 2)
            points["rgb"] = np.stack(colours(x, y, random), axis=1).astype(np.uint16) * 256
            points["sigma"] = (sigma.astype(np.float32).view(np.uint32) & 0xFFFF0000).view(np.float32)
            points["images"] = 3 + random.integers(0, 5, count)
            points.tofile(file)


def write_ortho(path):
    from osgeo import gdal, osr
    gdal.UseExceptions()
    gdal.SetConfigOption("GDAL_CACHEMAX", "1500")
    size, cell = args.pixels, SIDE / args.pixels
    plain = path + ".plain.tif"
    made = gdal.GetDriverByName("GTiff").Create(plain, size, size, 3, gdal.GDT_Byte, ["TILED=YES", "COMPRESS=JPEG", "PHOTOMETRIC=YCBCR", "BLOCKXSIZE=512", "BLOCKYSIZE=512"])
    made.SetGeoTransform([EAST, cell, 0, NORTH + SIDE, 0, -cell])
    crs = osr.SpatialReference()
    crs.ImportFromEPSG(32633)
    made.SetProjection(crs.ExportToWkt())
    random = np.random.default_rng(2)
    step = 512
    for row in range(0, size, step):
        count = min(step, size - row)
        y = np.broadcast_to(SIDE - (row + np.arange(count))[:, None] * cell, (count, size)).astype(np.float32)
        x = np.broadcast_to(np.arange(size)[None, :] * cell, (count, size)).astype(np.float32)
        for band, values in enumerate(colours(x, y, random)):
            made.GetRasterBand(band + 1).WriteArray(values, 0, row)
    made.FlushCache()
    made = None
    gdal.Translate(path, plain, format="COG", creationOptions=["COMPRESS=JPEG", "BLOCKSIZE=512", "BIGTIFF=YES", "NUM_THREADS=2"])
    os.remove(plain)


if not os.path.exists(os.path.join(project, "block.db")):
    collinea("simulate", project, "--images", 12, "--control-points", 0, "--observations-only", "--progress", "none")
    collinea("orient", project, "--progress", "none")
os.makedirs(products, exist_ok=True)
if not os.path.exists(os.path.join(products, "cloud.copc.laz")):
    las = os.path.join(products, "cloud.las")
    write_las(las)
    collinea("export", project, os.path.join(args.folder, "sorted"), "--format", "copc", "--progress", "none")
    os.rename(os.path.join(args.folder, "sorted", "cloud.copc.laz"), os.path.join(products, "cloud.copc.laz"))
    os.remove(las)
if not os.path.exists(os.path.join(products, "ortho.tif")):
    write_ortho(os.path.join(products, "ortho.tif"))
