# SPDX-License-Identifier: Apache-2.0
"""Figures of the pages on orientation, frames and what goes in and comes out."""
import math
import pathlib
import random

from drawing import BLUE, GREEN, GREY, INK, LIGHT, RED, Chart, Drawing, View, middle, steps

THEORY = pathlib.Path(__file__).resolve().parents[2] / "docs" / "theory"


def resection():
    """Three points and their rays; two rays that miss each other."""
    d = Drawing(640, 260)
    view = View(150, 215, 62, 20, 22)
    centre, points = (0.3, 0.6, 2.7), [(-1.6, 0.0, 0.0), (1.3, -0.7, 0.15), (0.9, 1.9, 0.4)]
    seen = [view(*p) for p in points]
    top = view(*centre)
    d.line(seen, BLUE, 1.5, fill=BLUE, opacity=0.12, close=True)
    for k, p in enumerate(seen):
        d.line([top, p], RED, 1.4)
        d.dot(p, BLUE)
        at = middle(top, p, 0.55)
        d.text((at[0] + (-22, 8, -20)[k], at[1] + (4, 4, 12)[k]), f"d{k + 1}", RED)
        d.text((p[0] + (-22, -4, 8)[k], p[1] + (4, 16, 2)[k]), f"P{k + 1}", BLUE)
    d.dot(top, INK, 4)
    d.text((top[0] + 8, top[1] - 4), "projection centre")
    at = middle(seen[0], seen[1])
    d.text((at[0] - 10, at[1] + 16), "√a12", BLUE)
    d.text((15, 254), "three points: the law of cosines for each pair of rays")
    view = View(470, 205, 62, 15, 18)
    a, b, va, vb = (-1.9, 0.0, 2.6), (1.7, 0.9, 2.7), (1.45, 0.25, -1.75), (-1.4, 0.3, -1.8)
    along_a, along_b = nearest(a, va, b, vb)
    foot_a, foot_b = [tuple(c + s * v for c, v in zip(o, way)) for o, way, s in ((a, va, along_a), (b, vb, along_b))]
    for o, way, name in ((a, va, "a"), (b, vb, "b")):
        d.line([view(*o), view(*(c + 1.5 * v for c, v in zip(o, way)))], RED, 1.4, arrow=True)
        d.dot(view(*o), INK, 4)
        at = view(*o)
        d.text((at[0], at[1] - 9), f"C{name}", anchor="middle")
        at = view(*(c + 0.35 * v for c, v in zip(o, way)))
        d.text((at[0] + (-12 if name == "a" else 12), at[1] + 6), f"v{name}", RED, "middle")
    d.line([view(*a), view(*b)], INK, 1.2, "5 3")
    at = middle(view(*a), view(*b))
    d.text((at[0], at[1] - 6), "B", anchor="middle")
    d.line([view(*foot_a), view(*foot_b)], GREEN, 2)
    point = middle(view(*foot_a), view(*foot_b))
    d.dot(point, GREEN, 4)
    d.text((point[0] + 9, point[1] + 4), "X", GREEN)
    d.text((350, 254), "two rays: the middle of the shortest connection")
    return d


def nearest(a, va, b, vb):
    """How far along both rays their shortest connection lies."""
    base = [q - p for p, q in zip(a, b)]
    n = cross(va, vb)
    n2 = dot(n, n)
    return dot(cross(base, vb), n) / n2, dot(cross(base, va), n) / n2


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(p * q for p, q in zip(a, b))


def factorisation():
    """W = M P, and the errors of the principal distance at each stage, from the table of the page."""
    d = Drawing(640, 250)
    for left, width, height, name, sizes in ((20, 110, 120, "W", "3m x n"), (160, 34, 120, "M", "3m x 4"), (214, 110, 34, "P", "4 x n")):
        d.box(left, 50, width, height, BLUE, BLUE, 0.12)
        d.text((left + width / 2, 44), name, anchor="middle")
        d.text((left + width / 2, 64 + height), sizes, GREY, "middle", 11)
        for k in (1, 2, 3):
            if height > 100:
                d.line([(left, 50 + 30 * k), (left + width, 50 + 30 * k)], BLUE, 0.8)
    d.text((138, 114), "=")
    d.text((75, 69), "λ u: image 1", BLUE, "middle", 11)
    d.text((75, 99), "image 2", BLUE, "middle", 11)
    d.text((15, 212), "rank 4; M T and T^-1 P do as well:")
    d.text((15, 228), "one K for all images finds T")
    rows = measured_errors(THEORY / "factorisation.md")
    chart = Chart(d, 395, 34, 205, 160, (0, 3), (0.3, 30), logarithmic=True)
    chart.axes([0, 1, 2, 3], [0.3, 1, 3, 10, 30], "", "error of c_x [px], noise of 0.3 px",
               lambda k: ("by pairs", "upgrade", "bundles", "their σ")[k])
    for (images, errors), colour in zip(rows, (RED, GREEN, BLUE)):
        chart.curve(list(enumerate(errors)), colour)
        chart.dots(list(enumerate(errors)), colour)
    for k, ((images, _), colour) in enumerate(zip(rows, (RED, GREEN, BLUE))):
        d.text((405 + 75 * k, 232), f"{images} images", colour, size=11)
    return d


def measured_errors(page):
    rows = []
    for line in page.read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 10 and cells[1] == "0.3":
            rows.append((cells[0], [float(cell) for cell in cells[5:9]]))
    return rows


def two_view():
    """Two centres, a point, its epipolar plane and lines; and how many samples the share of right matches asks for."""
    d = Drawing(640, 250)
    view = View(150, 190, 60, 12, 20)
    a, b, x = (-1.8, 0.0, 0.9), (1.6, 0.0, 0.8), (0.1, 2.3, 2.2)
    d.line([view(*a), view(*b), view(*x)], GREEN, 1, fill=GREEN, opacity=0.10, close=True)
    for centre, turn, name in ((a, 0.35, "p"), (b, -0.35, "q")):
        across, up = (math.cos(turn), -math.sin(turn), 0.0), (0.0, 0.0, 1.0)
        forward = (math.sin(turn), math.cos(turn), 0.0)
        at = lambda u, v: tuple(c + 0.75 * f + u * s + v * w for c, f, s, w in zip(centre, forward, across, up))
        corners = [view(*at(u, v)) for u, v in ((-0.5, -0.35), (0.5, -0.35), (0.5, 0.6), (-0.5, 0.6))]
        d.line(corners, BLUE, 1.3, fill=BLUE, opacity=0.08, close=True)
        other = b if centre is a else a

        def seen(point):
            way = [p - c for p, c in zip(point, centre)]
            depth = dot(way, forward)
            return dot(way, across) * 0.75 / depth, dot(way, up) * 0.75 / depth

        u, v = seen(x)
        # The epipolar line joins the images of two points of the other ray.
        far = seen(tuple(o + 3.0 * (p - o) for o, p in zip(other, x)))
        slope = (far[1] - v) / (far[0] - u)
        d.line([view(*at(s, v + slope * (s - u))) for s in (-0.5, 0.5)], RED, 1.5)
        d.dot(view(*at(u, v)), INK)
        spot = view(*at(u, v))
        d.text((spot[0] - 4, spot[1] - 7), name, INK, "end" if name == "p" else "end")
        d.line([view(*centre), view(*x)], INK, 1)
        d.dot(view(*centre), INK, 4)
    d.dot(view(*x), GREEN, 4)
    d.text((view(*x)[0] + 8, view(*x)[1]), "X", GREEN)
    d.text((view(*a)[0], view(*a)[1] + 22), "first centre", INK, "middle")
    d.text((view(*b)[0], view(*b)[1] + 22), "second centre", INK, "middle")
    d.text((15, 243), "q' E p = 0: q lies on the line of the plane of p and the base")
    chart = Chart(d, 420, 34, 200, 160, (0.2, 1), (1, 100000), logarithmic=True)
    chart.axes([0.2, 0.4, 0.6, 0.8, 1], [1, 10, 100, 1000, 10000, 100000], "share of right matches", "samples for 99.99 %")
    for size, colour, name in ((7, RED, "7 points"), (5, BLUE, "5 points"), (4, GREEN, "4 points")):
        needed = lambda w: max(1, math.log(1e-4) / math.log1p(-(w**size)))
        chart.curve([(w, needed(w)) for w in [s / 200 for s in range(40, 200)] if needed(w) <= 1e5], colour)
        d.text((chart.at(0.66, 1)[0], 54 + 15 * (7, 5, 4).index(size)), name, colour, size=11)
    return d


def on_sphere(lat_deg, lon_deg):
    lat, lon = math.radians(lat_deg), math.radians(lon_deg)
    return (math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat))


def draw_front(d, view, points, colour):
    """What of a line on the unit sphere is on the side of the viewer."""
    part = []
    for x, y, z in [*points, (0, 0, 0)]:
        away = math.sin(view.turn) * x + math.cos(view.turn) * y
        is_front = math.cos(view.down) * away - math.sin(view.down) * z < 0
        if is_front:
            part.append(view(x, y, z))
        elif part:
            if len(part) > 1:
                d.line(part, colour, 0.8)
            part = []


def frames():
    """The world at a place on the Earth; camera and image frame."""
    d = Drawing(640, 250)
    view = View(125, 125, 92, -25, 22)
    for lat in (-60, -30, 0, 30, 60):
        draw_front(d, view, [on_sphere(lat, lon) for lon in range(-180, 181, 4)], GREY if lat == 0 else "#bbb")
    for lon in range(-180, 180, 30):
        draw_front(d, view, [on_sphere(lat, lon) for lat in range(-90, 91, 4)], GREY if lon == 0 else "#bbb")
    d.line([(125 + 92 * math.cos(t / 30 * math.pi), 125 + 92 * math.sin(t / 30 * math.pi)) for t in range(61)], GREY, 1)
    b, l = math.radians(45), math.radians(-40)
    place = on_sphere(45, -40)
    east = (-math.sin(l), math.cos(l), 0.0)
    north = (-math.sin(b) * math.cos(l), -math.sin(b) * math.sin(l), math.cos(b))
    axes = ((east, "x east", (5, 8)), (north, "y north", (-56, -2)), (place, "z up", (5, 4)))
    for way, name, off in axes:
        tip = view(*(p + 0.6 * w for p, w in zip(place, way)))
        d.line([view(*place), tip], RED, 1.6, arrow=True)
        d.text((tip[0] + off[0], tip[1] + off[1]), name, RED)
    d.dot(view(*place), RED)
    d.text((15, 243), "world: topocentric at the origin (φ0, λ0, h0), metric")
    view = View(440, 60, 62, -22, 20)
    for way, name, off in (((1.1, 0, 0), "x right", (4, 4)), ((0, -1.1, 0), "y down", (-30, 18)), ((0, 0, -2.3), "z forward", (6, 4))):
        tip = view(*way)
        d.line([view(0, 0, 0), tip], BLUE, 1.6, arrow=True)
        d.text((tip[0] + off[0], tip[1] + off[1]), name, BLUE)
    d.line([view(s, t, -1.5) for s, t in ((-0.9, -0.7), (0.9, -0.7), (0.9, 0.7), (-0.9, 0.7))], INK, 1.2, fill=GREY, opacity=0.1, close=True)
    d.line([view(-0.9, 0.7, -1.5), view(-0.3, 0.7, -1.5)], INK, 1.8, arrow=True)
    d.line([view(-0.9, 0.7, -1.5), view(-0.9, 0.2, -1.5)], INK, 1.8, arrow=True)
    d.text((view(-0.3, 0.7, -1.5)[0] + 3, view(-0.3, 0.7, -1.5)[1] - 5), "u")
    d.text((view(-0.9, 0.2, -1.5)[0] - 14, view(-0.9, 0.2, -1.5)[1] + 4), "v")
    d.dot(view(0, 0, 0), BLUE, 4)
    d.text((view(0, 0, 0)[0] - 10, view(0, 0, 0)[1] - 8), "centre C", BLUE, "end")
    d.text((350, 243), "camera; pixels (u, v) from the upper left corner")
    return d


def matching():
    """Where a descriptor is accepted beside two of the other image, and a track that holds a contradiction."""
    d = Drawing(640, 230)
    one, two = (90.0, 110.0), (215.0, 110.0)
    for ratio, colour in ((0.9, GREY), (0.8, BLUE), (0.6, GREEN)):
        # Apollonius' circle: distance from the first below ratio times that from the second.
        share = ratio**2 / (1 - ratio**2)
        centre = one[0] - share * (two[0] - one[0])
        radius = ratio / (1 - ratio**2) * (two[0] - one[0])
        around = [(centre + radius * math.cos(t / 90 * math.pi), 110 + radius * math.sin(t / 90 * math.pi)) for t in range(181)]
        inside = [p for p in around if 15 < p[0] and 34 < p[1] < 186]
        d.line(sorted(inside, key=lambda p: math.atan2(p[1] - 110, p[0] - centre)), colour, 1.5)
        d.text((262, 50 + 16 * (0.9, 0.8, 0.6).index(ratio)), f"ρ = {ratio:g}", colour, size=11)
    for at, name in ((one, "nearest b"), (two, "second b")):
        d.dot(at, INK, 4)
        d.text((at[0], at[1] - 10), name, anchor="middle")
    d.text((15, 206), "a is matched to the nearest where it lies to the left")
    d.text((15, 222), "of the curve: d1 < ρ d2")
    for k in range(4):
        d.box(340 + 74 * k, 50, 60, 120, GREY)
        d.text((370 + 74 * k, 44), f"image {k + 1}", anchor="middle", size=11)
    tracks = ((((0, 85), (1, 78), (2, 90), (3, 82)), BLUE), (((0, 140), (1, 150), (2, 138)), GREEN))
    for points, colour in tracks:
        d.line([(370 + 74 * k, y) for k, y in points], colour, 1.5)
        for k, y in points:
            d.dot((370 + 74 * k, y), colour, 4)
    d.line([(370 + 74 * 2, 90), (370 + 74, 150)], RED, 1.5, "4 3")
    d.text((340, 196), "tracks; dashed: a wrong match would put")
    d.text((340, 212), "two features of an image into one")
    return d


def orientation():
    """Which image comes next: its known points counted by the cells that they occupy."""
    d = Drawing(640, 235)
    draw = random.Random(7)
    sets = (("60 points, a crowd", [(0.55 + 0.33 * draw.random(), 0.1 + 0.3 * draw.random()) for _ in range(60)]),
            ("30 points, spread", [(draw.random(), draw.random()) for _ in range(30)]))
    for k, (name, points) in enumerate(sets):
        left, top, size = 25 + 185 * k, 34, 150
        occupied = {(int(8 * x), int(8 * y)) for x, y in points}
        for column, row in occupied:
            d.box(left + size * column / 8, top + size * row / 8, size / 8, size / 8, LIGHT, BLUE, 0.15, 0.5)
        for line in range(1, 8):
            d.line([(left + size * line / 8, top), (left + size * line / 8, top + size)], LIGHT, 0.8)
            d.line([(left, top + size * line / 8), (left + size, top + size * line / 8)], LIGHT, 0.8)
        d.box(left, top, size, size)
        for x, y in points:
            d.dot((left + size * x, top + size * y), BLUE, 2)
        d.text((left, 26), name)
        score = {n: n * len({(int(n * x), int(n * y)) for x, y in points}) for n in (2, 4, 8, 16)}
        d.text((left, 204), " + ".join(str(v) for v in score.values()), size=11)
        d.text((left, 222), f"= {sum(score.values())}", RED if sum(score.values()) < 500 else GREEN)
    d.text((395, 60), "cells that hold a point, on grids")
    d.text((395, 76), "of 2, 4, 8 and 16 a side, each times")
    d.text((395, 92), "the cells a side: the image that is")
    d.text((395, 108), "covered best comes next, not the")
    d.text((395, 124), "one with most points")
    return d


def real_pairs():
    """Misfits at control of the film pair 27/28 in plan, from the table of the page."""
    d = Drawing(640, 300)
    places, misfits = {}, {}
    for line in (THEORY.parent / "manual" / "relative.md").read_text().splitlines():
        cells = line.split()
        if len(cells) == 5 and cells[0].isdigit() and line.startswith("    "):
            places[cells[0]] = (float(cells[1]), float(cells[2]))
    for line in (THEORY / "real_pairs.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 7 and cells[0] in places and cells[0] not in misfits:
            misfits[cells[0]] = [float(cell) for cell in cells[1:4]]
    d.box(25, 15, 250, 250)
    d.text((25, 285), "film of image 27, its eight control points")
    for name, (dx, dy, dz) in misfits.items():
        x, y = places[name]
        at = (150 + 1.05 * x, 140 - 1.05 * y)
        # The model lies on the ground turned by 90.2 degrees: east of the ground is -y of the film.
        d.line([at, (at[0] + 70 * dy, at[1] + 70 * dx)], RED, 1.5, arrow=True)
        d.dot(at, BLUE)
        d.text((at[0] + (-6 if dy > 0 else 6), at[1] + 14), name, INK, "end" if dy > 0 else "start", 11)
    d.line([(300, 250), (370, 250)], RED, 1.5)
    d.text((300, 268), "1 m in plan", RED)
    chart = Chart(d, 345, 34, 270, 160, (0.5, len(misfits) + 0.5), (-0.5, 0.5))
    names = list(misfits)
    chart.axes(range(1, len(names) + 1), [-0.4, -0.2, 0, 0.2, 0.4], "control point", "dZ, given less computed [m]", lambda k: names[k - 1])
    for k, name in enumerate(names):
        dz = misfits[name][2]
        d.line([chart.at(k + 1, 0), chart.at(k + 1, dz)], BLUE, 7)
    return d


def synthetic():
    """Profiles of two countries as sums of octaves of noise."""
    d = Drawing(640, 245)
    hills = [(130.0, 0.62), (55.0, 0.22), (22.0, 0.07), (8.0, 0.015), (1.7, 0.006)]
    rocks = [(600.0 / 2**k, 0.48**k) for k in range(10)]
    for left, title, octaves, length, relief in ((45, "village: octaves of 130 to 1.7 m [m]", hills, 400, 8),
                                                 (365, "rocks: octaves of 600 to 1.2 m [m]", rocks, 1200, 250)):
        draw = random.Random(4)
        waves = [[draw.uniform(-1, 1) for _ in range(int(length / spacing) + 4)] for spacing, _ in octaves]

        def at(x, most):
            total = 0.0
            for (spacing, share), wave in list(zip(octaves, waves))[:most]:
                i, t = int(x / spacing) + 1, x / spacing - int(x / spacing)
                total += share * (wave[i] + (wave[i + 1] - wave[i]) * t * t * t * (t * (6 * t - 15) + 10))
            return total

        xs = steps(0, length, 300)
        profile = [at(x, len(octaves)) for x in xs]
        low, high = min(profile), max(profile)
        scale = relief / (high - low)
        chart = Chart(d, left, 34, 250, 160, (0, length), (-0.35 * relief, 1.1 * relief))
        chart.axes([0, length / 2, length], [0, relief], "m", title, lambda x: f"{x:g}")
        for most, colour, width in ((1, GREY, 1), (2, GREEN, 1), (len(octaves), BLUE, 1.6)):
            chart.curve([(x, scale * (at(x, most) - low)) for x in xs], colour, width)
    d.text((45, 240), "grey: the first octave, green: two, blue: all", size=11)
    return d


def laz():
    """What stands in the file, and the layers of a chunk."""
    d = Drawing(640, 175)
    parts = ((70, "header"), (90, "records"), (50, "offset"), (95, "chunk 1"), (95, "chunk 2"), (30, "..."), (95, "chunk n"), (75, "table"))
    left = 20.0
    spots = {}
    for width, name in parts:
        colour = BLUE if name.startswith("chunk") else GREY
        d.box(left, 30, width, 30, colour, colour, 0.12)
        d.text((left + width / 2, 50), name, anchor="middle", size=11)
        spots[name] = left
        left += width
    d.line([(spots["offset"] + 25, 62), (spots["offset"] + 25, 74), (spots["table"] + 20, 74), (spots["table"] + 20, 62)], RED, 1.2, arrow=True)
    inner = ((110, "first point, as it is"), (60, "number"), (110, "lengths of layers"), (35, "x, y"), (40, "z"), (55, "class"), (70, "colour"), (100, "extra bytes"))
    left = 20.0
    d.line([(spots["chunk 2"], 60), (20, 100)], BLUE, 0.8, "3 3")
    d.line([(spots["chunk 2"] + 95, 60), (600, 100)], BLUE, 0.8, "3 3")
    for width, name in inner:
        colour = GREEN if name in ("x, y", "z", "class", "colour", "extra bytes") else GREY
        d.box(left, 100, width, 30, colour, colour, 0.12)
        d.text((left + width / 2, 120), name, anchor="middle", size=11)
        left += width
    d.text((20, 155), "a chunk stands alone: 50,000 points; a layer: one attribute of all of them, coded by itself", size=12)
    return d
