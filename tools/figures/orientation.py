# SPDX-License-Identifier: Apache-2.0
"""Figures of the pages on orientation: resection, factorisation."""
import math
import pathlib

from drawing import BLUE, GREEN, GREY, INK, RED, Chart, Drawing, View, middle

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
