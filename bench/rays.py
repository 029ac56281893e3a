# SPDX-License-Identifier: Apache-2.0
"""How far marks measured in pictures lie from their common point, as an oriented block sees it."""
import os
import xml.etree.ElementTree

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


def marks_of(file, width_px):
    """Mark -> [(image name, pixel, measured by hand)] of an Agisoft marker file, brought to pictures of that width.
    Its other places ("pinned" false) are the program's own projections of the mark, no measurements."""
    root = xml.etree.ElementTree.parse(file).getroot()
    scale = width_px / float(root.find(".//sensor/resolution").get("width"))
    names = {camera.get("id"): camera.get("label") for camera in root.iter("camera")}
    return {marker.get("marker_id"): [(names[at.get("camera_id")],
                                       scale * np.array([float(at.get("x")), float(at.get("y"))]),
                                       at.get("pinned") == "true") for at in marker.iter("location")]
            for marker in root.find(".//frame").iter("marker")}


def errors_px(folder, marks):
    """Mark -> [(image name, projection minus pixel)] at the common point of a mark's places, for marks in three
    oriented images or more. `marks`: mark -> [(image name, pixel)]."""
    model, result = model_of(folder), {}
    for mark, places in marks.items():
        seen = [(name, pixel) for name, pixel in places if name in model]
        if len(seen) < 3:
            continue
        images, pixels = [model[name] for name, _ in seen], [pixel for _, pixel in seen]
        point = common_point(images, pixels)
        result[mark] = [(name, projected(model[name], point) - pixel) for name, pixel in seen]
    return result


def pointing_px(errors, taken_s, within_s=1):
    """Standard deviation of a coordinate that pictures taken at nearly the same time show among each other: what the
    block does to a mark is common to them, what is left is the pointing. nan without such pictures."""
    differences = [a - b for places in errors.values() for i, (first, a) in enumerate(places)
                   for second, b in places[:i] if abs(taken_s[first] - taken_s[second]) < within_s]
    return np.sqrt(np.mean(np.square(differences)) / 2) if differences else np.nan
