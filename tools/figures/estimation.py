# SPDX-License-Identifier: Apache-2.0
"""Figures of the pages on adjustment, tests, planning and cameras."""
import math
import random

from drawing import BLUE, GREEN, GREY, INK, LIGHT, RED, Chart, Drawing, View, middle, steps


def camera():
    """Laws of projection over the angle from the axis, and a distortion that folds back."""
    d = Drawing(640, 245)
    chart = Chart(d, 45, 34, 250, 160, (0, 90), (0, 3))
    chart.axes([0, 30, 60, 90], [0, 1, 2, 3], "angle from the axis [°]", "radius in the image over f")
    laws = (("perspective", math.tan, 71, RED), ("equidistant", lambda t: t, 90, BLUE),
            ("equisolid", lambda t: 2 * math.sin(t / 2), 90, GREEN))
    for k, (name, law, last, colour) in enumerate(laws):
        chart.curve([(t, law(math.radians(t))) for t in steps(0, last, 90)], colour)
        d.text((55, 52 + 16 * k), name, colour)
    k1, k2 = -0.30, 0.03
    moved = lambda r: r * (1 + k1 * r * r + k2 * r**4)
    fold = next(r for r in steps(0, 2, 2000) if 1 + 3 * k1 * r * r + 5 * k2 * r**4 <= 0)
    second = Chart(d, 365, 34, 255, 160, (0, 2), (0, 1.2))
    second.axes([0, 0.5, 1, 1.5, 2], [0, 0.5, 1], "radius without distortion", "radius with k1 = -0.30, k2 = 0.03")
    second.curve([(r, r) for r in steps(0, 1.2, 12)], GREY, 1, "4 3")
    second.curve([(r, moved(r)) for r in steps(0, fold, 60)])
    second.curve([(r, moved(r)) for r in steps(fold, 2, 60)], RED, 1.4, "4 3")
    second.dots([(fold, moved(fold))], RED, 4)
    at = second.at(fold, moved(fold))
    d.text((at[0] + 4, at[1] - 26), "fold: beyond it", RED)
    d.text((at[0] + 4, at[1] - 12), "no image", RED)
    return d


def reliability():
    """A test of an observation: chance of an alarm, power, and the error that is found over the redundancy number."""
    d = Drawing(640, 245)
    density = lambda x: math.exp(-x * x / 2) / math.sqrt(2 * math.pi)
    limit, shift = 3.29, 4.13
    chart = Chart(d, 30, 34, 290, 160, (-4, 8), (0, 0.45))
    chart.axes([-4, 0, 3.29, 4.13, 8], [], "w", "", lambda x: {-4: "-4", 8: "8", 0: "0", 3.29: "k", 4.13: "δ0"}[x] if x != 4.13 else "  δ0")
    for middle_at, colour in ((0, BLUE), (shift, RED)):
        chart.curve([(x, density(x - middle_at)) for x in steps(-4, 8, 240)], colour)
    found = [chart.at(x, density(x - shift)) for x in steps(limit, 8, 100)]
    d.line([chart.at(limit, 0), *found, chart.at(8, 0)], RED, 0.5, fill=RED, opacity=0.18, close=True)
    d.line([chart.at(limit, 0), chart.at(limit, 0.43)], INK, 1, "4 3")
    d.text((chart.at(-0.1, 0)[0], 27), "right", BLUE, "middle")
    d.text((chart.at(shift + 1, 0)[0], 27), "with the error δ0: power 80 %", RED, "middle")
    second = Chart(d, 380, 34, 245, 160, (0, 1), (0, 30))
    second.axes([0, 0.25, 0.5, 0.75, 1], [0, 10, 20, 30], "redundancy number r", "least error that is found [sigmas]")
    second.curve([(r, shift / math.sqrt(r)) for r in steps(0.0195, 1, 200)])
    second.curve([(r, shift * math.sqrt((1 - r) / r)) for r in steps(0.0195, 1, 200)], RED, 1.6, "5 3")
    d.text((second.at(0.3, 0)[0], second.at(0, 21)[1]), "δ0 / √r")
    d.text((second.at(0.3, 0)[0], second.at(0, 18)[1]), "dashed: what it does,", RED, size=11)
    d.text((second.at(0.3, 0)[0], second.at(0, 15.6)[1]), "δ0 √((1 - r) / r)", RED, size=11)
    return d


def adjustment():
    """Blocks of the normal equations of a strip, and what is left without the points."""
    d = Drawing(640, 235)
    images, cell = 8, 13
    seen = [(i, j) for i in range(images) for j in range(24) if i - 1 <= j // 3 <= i + 1]
    left, top, small = 20, 30, 6
    size = cell * images + 24 * small
    d.box(left, top, size, size)
    start = lambda k: cell * k if k < images else cell * images + small * (k - images)
    side = lambda k: cell if k < images else small
    blocks = [(i, i) for i in range(images + 24)] + [(i, images + j) for i, j in seen] + [(images + j, i) for i, j in seen]
    scale = 190 / size
    d.parts.pop()
    d.box(left, top, 190, 190)
    for row, column in blocks:
        colour = BLUE if row < images and column < images else GREEN if row >= images and column >= images else RED
        d.box(left + scale * start(column), top + scale * start(row), scale * side(column), scale * side(row), colour, colour, 0.5, 0.3)
    d.text((left, 22), "all unknowns")
    reduced = sorted({(i, k) for i, j in seen for k, m in seen if m == j})
    at, side_px = 270, 13
    d.box(at, top, side_px * images, side_px * images)
    for row, column in reduced:
        d.box(at + side_px * column, top + side_px * row, side_px, side_px, BLUE, BLUE, 0.5, 0.3)
    d.text((at, 22), "points eliminated")
    for k, (colour, words) in enumerate(((BLUE, "images (6 x 6)"), (GREEN, "points (3 x 3)"), (RED, "an image that shows a point (6 x 3)"))):
        d.box(at, 158 + 20 * k, 11, 11, colour, colour, 0.5, 0.3)
        d.text((at + 18, 168 + 20 * k), words)
    d.text((410, 50), "S = U - W V⁻¹ W'")
    d.text((410, 68), "two images have a block in S", GREY)
    d.text((410, 84), "where they share points", GREY)
    return d


def planning():
    """Overlaps of a flight, and standard deviations of heights over the overlap along the strip."""
    d = Drawing(640, 240)
    ground, up, half = 200.0, 60.0, 62.0
    for k, x in enumerate((95.0, 145.0, 195.0)):
        d.line([(x - half, ground), (x, up), (x + half, ground)], (BLUE, RED, GREEN)[k], 1, fill=(BLUE, RED, GREEN)[k], opacity=0.08)
        d.dot((x, up), (BLUE, RED, GREEN)[k])
    d.line([(20, ground), (275, ground)], GREY)
    d.line([(95, 48), (145, 48)], INK, 1.2)
    d.text((120, 42), "b = (1 - p) H GSD", anchor="middle")
    d.line([(292, up), (292, ground)], INK, 1, arrow=True)
    d.text((298, 130), "h")
    d.line([(145 - half, 212), (95 + half, 212)], INK, 1.2)
    d.text((120, 228), "overlap p of two images", anchor="middle")
    chart = Chart(d, 375, 34, 245, 160, (0.5, 0.9), (0, 10))
    chart.axes([0.5, 0.6, 0.7, 0.8, 0.9], [0, 2, 4, 6, 8, 10], "forward overlap p", "sigma of heights [GSD], sigma 0.5 px", lambda x: f"{100 * x:g} %")
    f_over_side = 12.29 / 17.3 * 5280 / 3956  # focal length over the side of the image along the flight
    pair = lambda p: math.sqrt(2) * 0.5 * f_over_side / (1 - p)
    chart.curve([(p, pair(p)) for p in steps(0.5, 0.9, 80)], RED)

    def strip(p):  # all images of the strip that see the point, in sides of the image on the ground
        count = 1 / (1 - p)  # equally spaced; their squared distances from the mean are (n - 1 / n) / 12 together
        return 0.5 * f_over_side / math.sqrt((count - 1 / count) / 12)

    chart.curve([(p, strip(p)) for p in steps(0.5, 0.9, 80)])
    d.text((chart.at(0.62, 0)[0], chart.at(0, 8.3)[1]), "two neighbours", RED)
    d.text((chart.at(0.62, 0)[0], chart.at(0, 7.3)[1]), "all images of the strip", BLUE)
    return d
