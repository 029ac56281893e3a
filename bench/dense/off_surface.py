# SPDX-License-Identifier: Apache-2.0
"""Which share of a cloud lies off the surface, without a laser scan, and how much of the photographs it shows: who leaves out
what is difficult has little that is off. Needs numpy and PIL; used by table.py.

- Before a dark background every point of the object falls on the object in every photograph that has it in its frame: what
  falls beside it by more than two pixels in any of them is not on the surface.
- A block is cut into the photographs of even and of odd number, and each half matched by itself with the same poses. A point
  of one half is off where the photographs of the other see the surface beyond it or a little before it; where it is hidden
  by more than HIDDEN_GSD, or nothing is there, nothing is said. What both halves share, as errors of the poses, is not seen.
- A pixel of a photograph is shown where a point of the cloud that faces it falls within a pixel; before a dark background
  those of the object count.
What the cloud says of its own sigmas is told beside these shares, but decides none of them.
"""
import os

import numpy as np
from PIL import Image

DARK = 30  # of 255: darker than lit objects, brighter than black cloth; shadows on the object are closed
CLOSED_PX = 10
OFF_PX = 2
OFF_GSD = 3  # pixels of the ground
OFF_SIGMAS = 3
HIDDEN_GSD = 10  # what lies farther behind is hidden, not wrong
MATCHED_PIXELS = 3.2e6  # photographs with more are matched at half, a quarter ... of their size
ASKED = 300_000  # points of a cloud that are judged, evenly taken


class View:
    """A photograph: pixels of points, centre of the first 0.5. `lens`: k1 k2 p1 p2 k3."""

    def __init__(self, calibration, rotation, translation, size, lens=(0, 0, 0, 0, 0)):
        self.calibration, self.rotation, self.translation = map(np.asarray, (calibration, rotation, translation))
        self.size, self.lens = size, lens  # size: width, height

    def pixels(self, points):
        """columns, rows, depths"""
        x, y, z = (points @ self.rotation.T + self.translation).T
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y = x / z, y / z
            k1, k2, p1, p2, k3 = self.lens
            r = x * x + y * y
            radial = 1 + r * (k1 + r * (k2 + r * k3))
            x, y = (x * radial + 2 * p1 * x * y + p2 * (r + 2 * x * x), y * radial + p1 * (r + 2 * y * y) + 2 * p2 * x * y)
        k = self.calibration
        return k[0, 0] * x + k[0, 2], k[1, 1] * y + k[1, 2], z

    def centre(self):
        return -self.rotation.T @ self.translation

    def quaternion(self):
        r = self.rotation
        k = np.array([[r[0, 0] - r[1, 1] - r[2, 2], r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
                      [0, r[1, 1] - r[0, 0] - r[2, 2], r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
                      [0, 0, r[2, 2] - r[0, 0] - r[1, 1], r[1, 0] - r[0, 1]],
                      [0, 0, 0, r[0, 0] + r[1, 1] + r[2, 2]]])
        vector = np.linalg.eigh(k, "U")[1][:, -1]
        return vector[[3, 0, 1, 2]]


def middlebury_views(folder):
    """of *_par.txt: name, K, R, t by rows; centre of the first pixel is 0"""
    file = next(f for f in sorted(os.listdir(folder)) if f.endswith("_par.txt"))
    views = {}
    with open(os.path.join(folder, file)) as text:
        for line in text.read().splitlines()[1:]:
            if words := line.split():
                k, r, t = np.split(np.array(words[1:], float), [9, 18])
                views[words[0]] = View(half_more(k.reshape(3, 3)), r.reshape(3, 3), t, (640, 480))
    return views


def strecha_views(folder):
    """of *.camera: K, three zeros, R (world from camera), C, size; centre of the first pixel is 0"""
    views = {}
    for file in sorted(os.listdir(folder)):
        with open(os.path.join(folder, file)) as text:
            numbers = np.array(text.read().split(), float)
        r = numbers[12:21].reshape(3, 3).T
        size = (int(numbers[24]), int(numbers[25]))
        views[file.removesuffix(".camera")] = View(half_more(numbers[:9].reshape(3, 3)), r, -r @ numbers[21:24], size)
    return views


def half_more(k):
    return k + np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])


def read_model(folder):
    """of a COLMAP model in text, as `collinea export` writes it"""
    cameras, views = {}, {}
    with open(os.path.join(folder, "cameras.txt")) as text:
        for words in (line.split() for line in text if line.strip() and line[0] != "#"):
            values = [float(w) for w in words[4:]]
            k = np.array([[values[0], 0, values[2]], [0, values[1], values[3]], [0, 0, 1]])
            lens = (*values[4:8], values[8]) if len(values) > 8 else (*values[4:8], 0) if len(values) > 4 else (0,) * 5
            cameras[words[0]] = k, (int(words[2]), int(words[3])), lens
    with open(os.path.join(folder, "images.txt")) as text:
        lines = [line for line in text if line[0] != "#"]
    for line in lines[::2]:
        words = line.split(maxsplit=9)
        w, x, y, z = map(float, words[1:5])
        r = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                      [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                      [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])
        k, size, lens = cameras[words[8]]
        views[words[9].strip()] = View(k, r, np.array(words[5:8], float), size, lens)
    return views


def write_model(folder, views):
    """as a COLMAP model in text, without points"""
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "cameras.txt"), "w") as cameras, open(os.path.join(folder, "images.txt"), "w") as images:
        for number, (name, view) in enumerate(sorted(views.items()), 1):
            k, (k1, k2, p1, p2, k3) = view.calibration, view.lens
            words = [number, "FULL_OPENCV", *view.size, k[0, 0], k[1, 1], k[0, 2], k[1, 2], k1, k2, p1, p2, k3, 0, 0, 0]
            print(*words, file=cameras)
            print(number, *(repr(float(v)) for v in (*view.quaternion(), *view.translation)), number, name + "\n", file=images)
    open(os.path.join(folder, "points3D.txt"), "w").close()


def read_cloud(file):
    forms = {"double": "<f8", "float": "<f4", "uchar": "u1"}
    with open(file, "rb") as ply:
        count, fields = 0, []
        while (words := ply.readline().split())[0] != b"end_header":
            if words[:2] == [b"element", b"vertex"]:
                count = int(words[2])
            if words[0] == b"property":
                fields.append((words[2].decode(), forms[words[1].decode()]))
        return np.frombuffer(ply.read(), np.dtype(fields), count)


def places(cloud):
    return np.stack([cloud["x"], cloud["y"], cloud["z"]], 1)


def in_frame(columns, rows, depths, width, height):
    return (depths > 0) & (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)


def spread(mask, px):
    """the pixels within px of those of the mask, row by row as far as the circle reaches"""
    result = mask.copy()
    height, width = mask.shape
    for dy in range(-px, px + 1):
        dx = int((px * px - dy * dy) ** 0.5)
        row = np.zeros_like(mask)
        above, below = max(0, dy), height + min(0, dy)
        row[above:below] = mask[above - dy:below - dy]
        total = np.cumsum(np.pad(row, ((0, 0), (dx + 1, dx))), 1)
        result |= total[:, 2 * dx + 1:] > total[:, :width]
    return result


def object_in(photo, around_px=OFF_PX):
    """What is not clear background: bright, or enclosed by what is bright, with some pixels around it."""
    bright = np.asarray(Image.open(photo).convert("L")) > DARK
    closed = np.pad(bright & in_company(bright), 2 * CLOSED_PX)
    closed = ~spread(~spread(closed, CLOSED_PX), CLOSED_PX)
    return spread(closed, around_px)[2 * CLOSED_PX:-2 * CLOSED_PX, 2 * CLOSED_PX:-2 * CLOSED_PX]


def in_company(mask):
    """which pixels have four or more of the mask in the 3 x 3 around them"""
    padded = np.pad(mask, 1).astype(int)
    height, width = mask.shape
    return sum(padded[j:j + height, i:i + width] for j in range(3) for i in range(3)) >= 4


def beside_object(cloud, views, photos, box):
    """Which points of the cloud are in the box, and which of these fall beside the object in a photograph."""
    points = places(cloud)
    gsd = np.mean([np.median(v.pixels(points)[2]) / v.calibration[0, 0] for v in views.values()])
    low, high = np.array(box) + OFF_PX * gsd * np.array([[-1], [1]])
    inside = ((points >= low) & (points <= high)).all(1)
    points = points[inside]
    beside = np.zeros(len(points), bool)
    for name, view in views.items():
        columns, rows, depths = view.pixels(points)
        seen = in_frame(columns, rows, depths, *view.size)
        mask = object_in(os.path.join(photos, name))
        beside[seen] |= ~mask[rows[seen].astype(int), columns[seen].astype(int)]
    return inside, beside


class Shown:
    """The nearest point of a cloud in every pixel of a view, at the size it is matched in."""

    def __init__(self, view, points):
        self.view, self.shrink = view, 1
        while view.size[0] * view.size[1] > MATCHED_PIXELS * self.shrink**2:
            self.shrink *= 2
        self.width, self.height = (-(-s // self.shrink) for s in view.size)
        at, seen, depths = self.pixels(points)
        order = np.flatnonzero(seen)[np.argsort(-depths[seen], kind="stable")]
        self.nearest = np.full(self.width * self.height, -1)
        self.nearest[at[order]] = order  # the last one written, the nearest, stays

    def pixels(self, points):
        columns, rows, depths = self.view.pixels(points)
        columns, rows = columns / self.shrink, rows / self.shrink
        seen = in_frame(columns, rows, depths, self.width, self.height)
        at = np.where(seen, rows, 0).astype(int) * self.width + np.where(seen, columns, 0).astype(int)
        return at, seen, depths


def against(cloud, other, views_of_other):
    """Of points of `cloud`: how far they lie before the surface of `other`, across it, in pixels on the ground and in sigmas of
    both, by the photograph of other's that says fewest pixels; NaN where all find it hidden or nothing there."""
    cloud = cloud[::-(-len(cloud) // ASKED)]
    points, theirs = places(cloud), places(other)
    normals = np.stack([other["nx"], other["ny"], other["nz"]], 1).astype(float)
    gsds, sigmas = np.full(len(points), np.nan), np.full(len(points), np.nan)
    for view in views_of_other:
        shown = Shown(view, theirs)
        at, seen, depths = shown.pixels(points)
        gsd = depths / view.calibration[0, 0] * shown.shrink
        rays = points - view.centre()
        rays /= np.linalg.norm(rays, axis=1)[:, None]
        best_gsds, best_sigmas, filled = np.full(len(points), np.inf), np.full(len(points), np.inf), np.zeros(len(points), int)
        for down, right in ((down, right) for down in (-1, 0, 1) for right in (-1, 0, 1)):
            beside, column = at + down * shown.width + right, at % shown.width + right
            there = seen & (beside >= 0) & (beside < len(shown.nearest)) & (column >= 0) & (column < shown.width)
            index = np.where(there, shown.nearest[np.where(there, beside, 0)], -1)
            there &= index >= 0
            filled += there
            n, q = normals[index], theirs[index]
            cosine = -(n * rays).sum(1)  # normals look towards the cameras
            off = (n * (points - q)).sum(1) * np.sign(cosine)
            sigma = np.hypot(cloud["sigma_m"], other["sigma_m"][index]) * np.abs(cosine).clip(0.1)
            nearer = there & (np.abs(off) / gsd < np.abs(best_gsds))
            best_gsds[nearer], best_sigmas[nearer] = (off / gsd)[nearer], (off / sigma)[nearer]
        told = seen & (filled >= 5) & (best_gsds > -HIDDEN_GSD)
        better = told & ~(np.abs(best_gsds) >= np.abs(gsds))
        gsds[better], sigmas[better] = best_gsds[better], best_sigmas[better]
    return gsds, sigmas


def told_off(gsds, sigmas):
    """share off of those told, share told, share of these within OFF_SIGMAS, median distance [GSD]"""
    told = ~np.isnan(gsds)
    gsds, sigmas = np.abs(gsds[told]), np.abs(sigmas[told])
    return (gsds > OFF_GSD).mean(), told.mean(), (sigmas <= OFF_SIGMAS).mean(), np.median(gsds)


def shown_share(cloud, views, photos=None):
    """Of the pixels of the views, at the size they are matched in (of the object, where the photographs' folder is given), the
    share that a point facing the view falls into, or beside."""
    points, normals = places(cloud), np.stack([cloud["nx"], cloud["ny"], cloud["nz"]], 1)
    pixels = filled = 0
    for name, view in views.items():
        facing = ((view.centre() - points) * normals).sum(1) > 0
        shown = Shown(view, points[facing])
        there = spread((shown.nearest >= 0).reshape(shown.height, shown.width), 1)
        wanted = object_in(os.path.join(photos, name), 0) if photos else np.ones_like(there)
        pixels += wanted.sum()
        filled += (there & wanted).sum()
    return filled / pixels
