# SPDX-License-Identifier: Apache-2.0
"""How far marks measured in pictures lie from their common point, as an oriented block sees it."""
import os

import numpy as np


def rotation_of(w, x, y, z):
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def rows_of(folder, name):
    with open(os.path.join(folder, name)) as lines:
        return [line.split() for line in lines if not line.startswith("#")]


def model_of(folder):
    """Image name -> (rotation, translation, camera parameters) of a COLMAP text model with FULL_OPENCV cameras."""
    cameras = {}
    for row in rows_of(folder, "cameras.txt"):
        if row[1] != "FULL_OPENCV":
            raise ValueError(f"camera model {row[1]}")
        cameras[row[0]] = np.array(list(map(float, row[4:])))
    images = {}
    for row in rows_of(folder, "images.txt")[0::2]:
        if len(row) >= 10:
            values = list(map(float, row[1:8]))
            images[row[9]] = (rotation_of(*values[:4]), np.array(values[4:]), cameras[row[8]])
    return images


def distorted(camera, xy):
    _, _, _, _, k1, k2, p1, p2, k3, k4, k5, k6 = camera
    x, y = xy
    r2 = x * x + y * y
    factor = (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1 + r2 * (k4 + r2 * (k5 + r2 * k6)))
    return np.array([x * factor + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                     y * factor + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y])


def projected(image, point):
    rotation, translation, camera = image
    p = rotation @ point + translation
    return camera[:2] * distorted(camera, p[:2] / p[2]) + camera[2:4]


def ray_of(image, pixel):
    camera = image[2]
    wanted = (np.asarray(pixel) - camera[2:4]) / camera[:2]
    xy = wanted.copy()
    for _ in range(30):
        xy -= distorted(camera, xy) - wanted
    return xy


def common_point(images, pixels):
    """Least squares of the pixel errors, from the linear intersection of the rays."""
    rows = []
    for image, pixel in zip(images, pixels):
        matrix, xy = np.column_stack([image[0], image[1]]), ray_of(image, pixel)
        rows += [xy[0] * matrix[2] - matrix[0], xy[1] * matrix[2] - matrix[1]]
    solution = np.linalg.svd(np.array(rows))[2][-1]
    point = solution[:3] / solution[3]
    step = 1e-6 * np.linalg.norm(images[0][0].T @ images[0][1] + point)
    for _ in range(10):
        errors = np.concatenate([projected(i, point) - p for i, p in zip(images, pixels)])
        slopes = np.column_stack([
            np.concatenate([projected(i, point + step * axis) - p for i, p in zip(images, pixels)]) - errors
            for axis in np.eye(3)]) / step
        point = point - np.linalg.lstsq(slopes, errors, rcond=None)[0]
    return point


def errors_px(folder, marks_file):
    """Mark -> distances [px] of its measurements from its common point, for marks in three oriented images or more.
    `marks_file`: a line with the reference system, then lines of x y z column row image."""
    model, marks = model_of(folder), {}
    with open(marks_file) as lines:
        for row in (line.split() for line in list(lines)[1:]):
            if len(row) >= 6 and row[5] in model:
                marks.setdefault(tuple(row[:3]), []).append((model[row[5]], np.array([float(row[3]), float(row[4])])))
    result = {}
    for name, seen in marks.items():
        if len(seen) < 3:
            continue
        images, pixels = zip(*seen)
        point = common_point(images, pixels)
        result[name] = np.array([np.linalg.norm(projected(i, point) - p) for i, p in seen])
    return result
