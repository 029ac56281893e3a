# SPDX-License-Identifier: Apache-2.0
"""What the benchmarks know of real blocks with known cameras, and how an oriented block is compared with them."""
import glob
import os

import numpy as np

# fx, fy, cx, cy [px], centre of the first pixel at (0.5, 0.5)
STRECHA = {"fountain-P11": "2759.48,2764.16,1521.19,1007.31", "Herz-Jesus-P8": "1379.74,1382.08,760.595,503.655",
           "entry-P10": "1379.74,1382.08,760.595,503.655", "castle-P19": "1379.74,1382.08,760.595,503.655"}
# The camera of park_gate's reference: K_fullres.txt, whose first pixel has its centre at (1, 1), at half the size. It has no
# distortion, and pixels 1 % wider than high.
PARK_GATE = "1234.5372,1247.6166,488.1367,316.7557"


def similarity(a, b):
    """Umeyama (1991): scale, rotation, translation with b = s R a + t."""
    ma, mb = a.mean(0), b.mean(0)
    u, d, vt = np.linalg.svd((b - mb).T @ (a - ma))
    s = np.diag([1, 1, np.sign(np.linalg.det(u) * np.linalg.det(vt))])
    r = u @ s @ vt
    scale = (d * np.diag(s)).sum() / ((a - ma) ** 2).sum()
    return scale, r, mb - scale * r @ ma


def centres_of_model(folder):
    """Projection centres of a COLMAP text model by the image names without their ending."""
    centres = {}
    lines = [l for l in open(os.path.join(folder, "images.txt")) if not l.startswith("#")]
    for line in lines[0::2]:
        p = line.split()
        if len(p) < 10:
            continue
        w, x, y, z = map(float, p[1:5])
        r = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                      [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                      [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
        centres[os.path.splitext(os.path.basename(p[9]))[0]] = -r.T @ np.array(list(map(float, p[5:8])))
    return centres


def strecha_centres(folder):
    centres = {}
    for f in glob.glob(os.path.join(folder, "gt_dense_cameras", "*.camera")):
        rows = [list(map(float, l.split())) for l in open(f) if l.strip()]
        centres[os.path.basename(f).split(".")[0]] = np.array(rows[7])
    return centres


def camera_matrix_centres(file):
    """Projection centres from lines of an image name and its 3 x 4 camera matrix, row by row."""
    centres = {}
    for line in open(file):
        p = line.split()
        if line.startswith("#") or len(p) != 13:
            continue
        m = np.array(list(map(float, p[1:]))).reshape(3, 4)
        centres[os.path.splitext(p[0])[0]] = -np.linalg.solve(m[:, :3], m[:, 3])
    return centres


def park_gate_centres(file):
    """The published cameras are listed in the order of unpadded names: 0, 1, 10, 11, ... Their own model has no
    distortion, so that differences of 0.2 % of the spread are not all ours."""
    listed = camera_matrix_centres(file)
    order = sorted(map(str, range(len(listed))))
    return {name: listed[sorted(listed)[int(order[int(name)])]] for name in listed}


def centre_errors(model_folder, truth):
    """Distances of the centres of a COLMAP text model from the true ones after the best similarity; None below 3."""
    found = centres_of_model(model_folder)
    names = sorted(set(found) & set(truth))
    if len(names) < 3:
        return None
    a, b = np.array([found[n] for n in names]), np.array([truth[n] for n in names])
    s, r, t = similarity(a, b)
    return np.linalg.norm(b - (s * a @ r.T + t), axis=1)
