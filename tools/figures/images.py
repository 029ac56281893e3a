# SPDX-License-Identifier: Apache-2.0
"""Figures of the pages on matching: windows, candidates, scale space, epipolar pairs."""
import math
import random

from drawing import BLUE, GREEN, GREY, INK, LIGHT, RED, Chart, Drawing, middle, steps


def texture(seed, waves=9, shortest=3.0, longest=14.0):
    """Grey values along a line: a sum of waves (mean 0, of about 40 grey values)."""
    draw = random.Random(seed)
    parts = [(2 * math.pi / draw.uniform(shortest, longest), draw.uniform(0, 2 * math.pi)) for _ in range(waves)]
    return lambda u: sum(40 / math.sqrt(waves / 2) * math.sin(k * u + phase) for k, phase in parts)


def correlation(a, b):
    mean_a, mean_b = sum(a) / len(a), sum(b) / len(b)
    ab = sum((x - mean_a) * (y - mean_b) for x, y in zip(a, b))
    return ab / math.sqrt(sum((x - mean_a) ** 2 for x in a) * sum((y - mean_b) ** 2 for y in b))


def pair():
    """A window on a slope in the other image, and the interval of disparities that is searched round a model."""
    d = Drawing(640, 240)
    d.text((15, 18), "left window")
    d.text((150, 18), "in the right image (gx 0.3, gy 0.15)")
    cell, gx, gy = 8, 0.3, 0.15
    for left, across, down, colour in ((70, 0, 0, BLUE), (230, gx, gy, RED)):
        for k in range(-5, 6):
            for one, other in (((k, -5), (k, 5)), ((-5, k), (5, k))):
                d.line([(left + cell * (u - across * u - down * v), 80 + cell * v) for u, v in (one, other)], colour, 0.8)
        d.dot((left, 80), colour)
    d.line([(230 - 40, 40), (230 + 40, 40), (230 + 40, 120), (230 - 40, 120)], GREY, 1, "4 3", close=True)
    d.text((15, 142), "column = x + u - d - gx u - gy v: resampled by the")
    d.text((15, 158), "inverse of that shear it is a square of the right")
    d.text((15, 174), "image: slopes correlate as flat ground does.")
    points = [(0, 12), (14, 15), (22, 26), (30, 27), (62, 18), (76, 20), (90, 19)]
    chart = Chart(d, 370, 34, 250, 160, (0, 90), (0, 60))
    chart.axes([0, 30, 60, 90], [0, 20, 40, 60], "column [px]", "disparity [px]: model, and where is looked")

    def model(x):
        for (x0, y0), (x1, y1) in zip(points, points[1:]):
            if x <= x1:
                return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
        return points[-1][1]

    def reach(x):  # a fixed margin and half the distance of the nearest point
        return 3 + min(abs(x - px) for px, _ in points) / 2

    along = steps(0, 90, 90)
    band = [chart.at(x, model(x) + reach(x)) for x in along] + [chart.at(x, model(x) - reach(x)) for x in reversed(along)]
    d.line(band, BLUE, 0.6, fill=BLUE, opacity=0.15, close=True)
    chart.curve(points, BLUE)
    chart.dots(points, BLUE)
    hill = [(x, 22 + 8.5 * math.exp(-((x - 46) / 6) ** 2)) for x in steps(34, 58, 24)]
    chart.curve(hill, RED, 1.6, "5 3")
    d.text(chart.at(32, 41), "hill without a point", RED)
    return d


def stereo():
    """Two photographs seen from above, and the common cameras they are resampled into."""
    d = Drawing(640, 235)
    left, right, f, ground = (170.0, 35.0), (420.0, 35.0), 60.0, 190.0
    point = (275.0, ground)
    d.line([(40, ground + 4), (140, ground - 3), (220, ground + 5), point, (350, ground - 6), (490, ground + 6), (560, ground)], GREY)
    foot = {}
    for centre, turn in ((left, 9), (right, -7)):
        t = math.radians(turn)
        mid = (centre[0] + math.sin(t) * f, centre[1] + math.cos(t) * f)
        d.line([(mid[0] + s * 62 * math.cos(t), mid[1] - s * 62 * math.sin(t)) for s in (-1, 1)], GREY, 1.5, "5 3")
        d.line([(centre[0] - 68, centre[1] + f), (centre[0] + 68, centre[1] + f)], BLUE, 2)
        d.line([centre, (centre[0], centre[1] + f + 12)], BLUE, 0.8, "2 3")
        d.line([centre, point], RED, 1)
        d.dot(centre)
        foot[centre] = (centre[0] + f / ground * (point[0] - centre[0]) * ground / (ground - centre[1]), centre[1] + f)
        d.dot(foot[centre], RED)
    d.line([left, right], INK, 1.2)
    d.text((295, 27), "base b", anchor="middle")
    d.text((foot[left][0] - 7, foot[left][1] + 15), "x", RED, "end")
    d.text((foot[right][0] + 7, foot[right][1] + 15), "x'", RED)
    d.text((left[0] - 6, left[1] + 30), "f", BLUE, "end")
    d.text((20, 130), "photographs as taken: dashed", GREY)
    d.text((20, 147), "resampled: both along the base", BLUE)
    d.line([(590, left[1]), (590, ground)], INK, 1, arrow=True)
    d.text((597, 115), "z")
    d.text((320, 226), "one row for both:  d = x - x' = cx - cx' + f b / z", anchor="middle")
    return d


def least_squares_matching():
    """A window of the reference, the same of the other image, and the residuals over the iterations."""
    d = Drawing(640, 235)
    shade, shift, gain, offset, half = texture(4, shortest=6, longest=25), 1.6, 0.75, 18.0, 8
    seen = lambda x: gain * shade(x - shift) + offset
    pixels = range(-half, half + 1)
    reference = [shade(u) for u in pixels]
    slope = lambda u: (shade(u + 0.01) - shade(u - 0.01)) / 0.02
    chart = Chart(d, 45, 34, 250, 150, (-half, half), (-130, 130))
    chart.axes([-8, -4, 0, 4, 8], [-100, 0, 100], "u [px]", "grey: reference T (blue), other image S (red)")
    chart.curve([(u, shade(u)) for u in steps(-half, half, 96)])
    chart.dots([(u, shade(u)) for u in pixels], BLUE, 2.2)
    chart.curve([(u, seen(u)) for u in steps(-half, half, 96)], RED)
    chart.dots([(u, seen(u)) for u in pixels], RED, 2.2)
    residuals = Chart(d, 365, 34, 255, 150, (-half, half), (-130, 130))
    residuals.axes([-8, -4, 0, 4, 8], [-100, 0, 100], "u [px]", "residuals (S(p + u) - o) / g - T")
    p = 0.0
    names = []
    for step, colour in enumerate(("#e3a008", RED, GREEN, INK)):
        at = [seen(u + p) for u in pixels]
        mean_t, mean_s = sum(reference) / len(at), sum(at) / len(at)
        g = sum((t - mean_t) * (s - mean_s) for t, s in zip(reference, at)) / sum((t - mean_t) ** 2 for t in reference)
        r = [(s - mean_s) / g - (t - mean_t) for s, t in zip(at, reference)]
        residuals.curve(list(zip(pixels, r)), colour)
        names.append((f"{p:.2f}", colour))
        slopes = [slope(u) for u in pixels]
        p -= sum(s * e for s, e in zip(slopes, r)) / sum(s * s for s in slopes)
    for k, (name, colour) in enumerate(names):
        d.text((500 + 32 * k, 229), name, colour, size=11)
    d.text((495, 229), "p [px] of iterations 0 to 3:", anchor="end", size=11)
    d.text((45, 229), f"true shift {shift} px, gain {gain}, offset {offset:g}", size=11)
    return d


def multi_image_matching():
    """Depths along the ray of the reference: what each image says, and what all say together."""
    d = Drawing(640, 280)
    centres, half, f, depth = [-30.0, 38.0, 75.0], 6, 100.0, 100.0
    shade = texture(1, waves=7, shortest=4.0, longest=6.5)
    chart = Chart(d, 330, 34, 290, 190, (80, 120), (-1, 1))
    chart.axes([80, 90, 100, 110, 120], [-1, -0.5, 0, 0.5, 1], "depth along the ray of the reference [m]", "correlation with the reference")
    reference = [shade(u) for u in range(-half, half + 1)]
    depths = steps(80, 120, 200)
    sums = [0.0] * len(depths)
    for centre, colour in zip(centres, ("#7fb2d9", "#8fc795", "#e0b070")):
        # Flat ground at `depth`; where the ray of the reference has depth z, image `centre` looks f b (1 / z - 1 / depth) off.
        found = [correlation(reference, [shade(u + f * centre * (1 / z - 1 / depth)) for u in range(-half, half + 1)]) for z in depths]
        chart.curve(list(zip(depths, found)), colour, 1.4)
        sums = [s + rho / len(centres) for s, rho in zip(sums, found)]
    chart.curve(list(zip(depths, sums)), INK, 2.4)
    best = max(range(len(depths)), key=lambda k: sums[k])
    chart.dots([(depths[best], sums[best])], RED, 4)
    d.text((330, 272), "thin: each other image alone; thick: their mean", size=11)
    place = lambda x, z: (110 + 1.25 * x, 40 + 1.55 * z)
    d.line([place(-75, 101), place(-30, 99), place(0, 100), place(60, 101), place(120, 98)], GREY)
    for z in steps(80, 120, 8):
        d.dot(place(0, z), RED, 2.2, hollow=True)
        for centre, colour in zip(centres, ("#7fb2d9", "#8fc795", "#e0b070")):
            if z in (80, 100, 120):
                d.line([place(centre, 0), place(0, z)], colour, 1.6 if z == 100 else 0.7, None if z == 100 else "3 3")
    d.line([place(0, 0), place(0, 124)], BLUE, 1.6)
    for centre, name, colour in ((0.0, "reference", BLUE), *zip(centres, "123", ("#7fb2d9", "#8fc795", "#e0b070"))):
        d.dot(place(centre, 0), colour, 4)
        d.text((place(centre, 0)[0], 30), name, INK, "middle")
    d.dot(place(0, 100), RED, 4)
    d.text((place(0, 100)[0] + 9, place(0, 100)[1] + 17), "X", RED)
    d.text((15, 272), "one unknown: the depth of X on the ray", size=11)
    return d


def relaxation():
    """Right and wrong candidates of points along a line, and their probabilities over the rounds."""
    d = Drawing(640, 250)
    draw = random.Random(3)
    points = [7.0 * k for k in range(24)]
    smooth = lambda x: 6 + 3 * math.sin(x / 40)
    candidates = [[smooth(x) + draw.gauss(0, 0.3)] + [draw.uniform(-12, 24) for _ in range(3)] for x in points]
    chances = [[0.8 / len(each)] * len(each) for each in candidates]  # all as similar; 0.2: none is right
    chart = Chart(d, 45, 34, 270, 160, (-4, 168), (-14, 26))
    chart.axes([0, 40, 80, 120, 160], [-10, 0, 10, 20], "place of the point [px]", "parallax of the candidates [px]")
    history = [[list(each) for each in chances]]
    for _ in range(20):
        chances = [one_round(i, points, candidates, history[-1]) for i in range(len(points))]
        history.append(chances)
    for x, each, last in zip(points, candidates, chances):
        for k, parallax in enumerate(each):
            chart.dots([(x, parallax)], BLUE if k == 0 else RED, 3, hollow=last[k] < 0.7)
    d.text((45, 246), "blue: right, red: wrong; filled: taken (0.7 or more)", size=11)
    rounds = Chart(d, 370, 34, 250, 160, (0, 20), (0, 1))
    rounds.axes([0, 5, 10, 15, 20], [0, 0.25, 0.5, 0.7, 1], "round", "probability, candidates of three points")
    for i in (0, 9, 17):
        for k in range(4):
            rounds.curve([(r, history[r][i][k]) for r in range(21)], BLUE if k == 0 else RED, 1.6 if k == 0 else 1)
    return d


def one_round(i, points, candidates, chances):
    near = sorted((k for k in range(len(points)) if k != i), key=lambda k: abs(points[k] - points[i]))[:12]
    new = []
    for parallax, p in zip(candidates[i], chances[i]):
        q = 0.0
        for k in near:
            s = 1 + 0.05 * abs(points[k] - points[i])
            q += sum(c * math.exp(-((other - parallax) ** 2) / (2 * s * s)) for other, c in zip(candidates[k], chances[k])) / len(near)
        new.append(p * (0.3 + 3 * q))
    total = sum(new) + 1 - sum(chances[i])
    return [p / total for p in new]


def sift():
    """Differences of Gaussians over scale for blobs of three sizes; blur of the levels of two octaves."""
    d = Drawing(640, 240)
    chart = Chart(d, 55, 34, 330, 160, (0, 9), (0, 0.14))
    names = {k: f"{1.6 * 2 ** (k / 3):.1f}" for k in range(10)}
    chart.axes(range(10), [0, 0.05, 0.1], "blur of the level [px]", "difference of Gaussians in the middle of a blob", lambda k: names[k])
    ratio = 2 ** (1 / 3)
    for size, colour in ((2.5, BLUE), (4.0, GREEN), (7.0, RED)):
        # A Gaussian blob of that size blurred by b has size^2 / (size^2 + b^2) of its contrast left in its middle.
        left = lambda b: size**2 / (size**2 + b**2)
        response = lambda k: left(1.6 * ratio**k) - left(1.6 * ratio ** (k + 1))
        chart.curve([(k, response(k)) for k in steps(0, 9, 180)], colour)
        chart.dots([(k, response(k)) for k in range(10)], colour, 2.2)
        best = max(steps(0, 9, 900), key=response)
        peak = chart.at(best, response(best))
        d.line([(peak[0], peak[1] - 3), (peak[0], 46)], colour, 0.8, "3 3")
        d.text((peak[0], 43), f"{size:g} px", colour, "middle", 11)
    d.text((425, 17), "levels, with their blur [px]")
    for octave, left, cell in ((0, 450, 11), (1, 560, 6)):
        for level in range(6):
            row = 190 - 28 * level
            d.line([(left, row), (left + 5 * cell, row), (left + 7 * cell, row - 1.4 * cell), (left + 2 * cell, row - 1.4 * cell)], BLUE, 1,
                   fill=BLUE, opacity=0.12, close=True)
            at = (left - 4, row) if octave == 0 else (left + 7 * cell + 4, row)
            d.text(at, f"{1.6 * 2 ** (octave + level / 3):.1f}", GREY, "end" if octave == 0 else "start", 10)
        d.text((left + 3 * cell, 208), f"octave {octave}", anchor="middle", size=11)
    d.line([(450 + 6 * 11, 190 - 3 * 28 - 7), (562, 190 - 6)], RED, 1, "4 3", arrow=True)
    d.text((425, 229), "every second pixel of level 3", RED, size=11)
    return d


def tags():
    """A tag seen obliquely: its cells, the crossing of the diagonals, which is the image of its centre, and the mean of the corners."""
    d = Drawing(640, 250)
    code = ["0100", "0010", "1110", "0100"]
    side, distance, tilt = 138, 2.2, 0.95
    def image(u, v):  # of a position on the tag (-0.5 .. 0.5), turned and tilted about a horizontal axis
        a = 0.35
        x, y = u * math.cos(a) - v * math.sin(a), u * math.sin(a) + v * math.cos(a)
        depth = distance - y * math.sin(tilt)
        return 165 + side * distance * x / depth, 125 + side * distance * y * math.cos(tilt) / depth
    def cell(u, v, size):
        return [image(u, v), image(u + size, v), image(u + size, v + size), image(u, v + size)]
    d.line(cell(-0.5 - 1 / 6, -0.5 - 1 / 6, 8 / 6), GREY, 1, "3 3", close=True)
    d.line(cell(-0.5, -0.5, 1), INK, 1, fill=INK, opacity=0.75, close=True)
    for row, bits in enumerate(code):
        for column, bit in enumerate(bits):
            if bit == "1":
                d.line(cell(-0.5 + (column + 1) / 6, -0.5 + (row + 1) / 6, 1 / 6), INK, 0.5, fill="#fff", close=True)
    corners = cell(-0.5, -0.5, 1)
    for i in (0, 1):
        d.line([corners[i], corners[i + 2]], BLUE, 1.2)
    d.dot(image(0, 0), BLUE, 4)
    mean = [sum(c[k] for c in corners) / 4 for k in (0, 1)]
    d.dot(mean, RED, 4)
    for k, corner in enumerate(corners):
        d.dot(corner, GREEN, 3)
        d.text((corner[0] + (8 if k in (1, 2) else -8), corner[1] + 4), str(k + 1), GREEN, "start" if k in (1, 2) else "end", 11)
    d.text((300, 60), "crossing of the diagonals: image of the centre", BLUE)
    d.text((300, 80), "mean of the corners: nearer to the nearer side", RED)
    d.text((300, 100), "corners of the dark square, as printed", GREEN)
    d.text((300, 120), "light ground of a cell, which a tag needs", GREY)
    chart = Chart(d, 330, 150, 280, 60, (-4, 4), (0, 1))
    chart.axes(range(-4, 5, 2), [0, 1], "across a border of cells [px]", "light", lambda k: str(k))
    for blur, colour in ((0.7, BLUE), (1.4, GREEN)):
        chart.curve([(t, 0.5 + 0.5 * math.erf(t / blur / math.sqrt(2))) for t in steps(-4, 4, 80)], colour)
    return d
