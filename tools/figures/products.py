# SPDX-License-Identifier: Apache-2.0
"""Figures of the pages on surfaces and pictures of them."""
import math
import random

from drawing import BLUE, GREEN, GREY, INK, LIGHT, RED, Chart, Drawing, middle, steps


def town(x):
    """A profile: ground, a house with a flat roof, a gabled one (m)."""
    if 22 <= x <= 38:
        return 14.0
    if 62 <= x <= 80:
        return 8.0 + 6.0 * (1 - abs(x - 71) / 9)
    return 2.0 + 0.8 * math.sin(x / 14)


def hides(centre, x):
    """Whether the profile rises above the line from its point at x to the projection centre."""
    z = town(x)
    for k in range(1, 400):
        s = k / 400
        at = x + s * (centre[0] - x)
        if town(at) > z + s * (centre[1] - z) + 0.2 and abs(at - x) > 0.4:
            return True
    return False


def runs(values):
    """Beginning, end and value of what follows each other alike and is not empty."""
    start = 0
    for k in range(1, len(values) + 1):
        if k == len(values) or values[k] != values[start]:
            if values[start]:
                yield start, min(k, len(values) - 1), values[start]
            start = k


def orthophoto():
    """A profile with houses, what each of two views sees, and where the picture takes its colours from."""
    d = Drawing(640, 260)
    place = lambda x, z: (40 + 5.8 * x, 200 - 3.6 * z)
    views = ((12.0, 44.0, BLUE, "view 1"), (84.0, 44.0, RED, "view 2"))
    profile = [(x, town(x)) for x in steps(0, 96, 960)]
    d.line([place(*p) for p in profile], INK, 1.6)
    for k, (x, z, colour, name) in enumerate(views):
        d.dot(place(x, z), colour, 4)
        d.text((place(x, z)[0] + 9, place(x, z)[1] + 4), name, colour)
        row = 214 + 12 * k
        for a, b, _ in runs([not hides((x, z), at) for at in steps(0, 96, 384)]):
            d.line([(place(a / 4, 0)[0], row), (place(b / 4, 0)[0], row)], colour, 5)
        d.text((place(96, 0)[0] + 8, row + 4), "sees", colour, size=11)
    # The line of sight that passes the edge of a roof, and where it meets the ground behind.
    for (x, z, colour, _), edge in zip(views, ((38.0, 14.0), (62.0, 8.0))):
        far = next(s for s in steps(1, 3, 4000) if z + s * (edge[1] - z) < town(x + s * (edge[0] - x)) and s > 1.02)
        d.line([place(x, z), place(x + far * (edge[0] - x), z + far * (edge[1] - z))], colour, 1, "5 3")
    best = []
    for at in steps(0, 96, 384):
        seen = [(abs(at - x), colour) for x, z, colour, _ in views if not hides((x, z), at)]
        best.append(min(seen)[1] if seen else None)
    for a, b, colour in runs(best):
        d.line([(place(a / 4, 0)[0], 242), (place(b / 4, 0)[0], 242)], colour, 9)
    d.text((place(96, 0)[0] + 8, 246), "taken", INK, size=11)
    d.text((320, 16), "what a house hides from one view the other one may see; taken is the nearer of those that do", anchor="middle", size=11)
    return d


def rectification():
    """Plane and image; how far things before the plane are shifted in its picture."""
    d = Drawing(640, 240)
    wall, centre = 60.0, (300.0, 190.0)
    d.line([(40, wall), (330, wall)], INK, 2)
    d.text((285, 50), "plane")
    d.dot(centre, INK, 4)
    d.text((centre[0] - 10, centre[1] + 18), "projection centre", INK, "end")
    foot = (140.0, wall)
    thing = (140.0, wall + 38)
    reach = (centre[1] - wall) / (centre[1] - thing[1])
    seen = (centre[0] + reach * (thing[0] - centre[0]), wall)
    d.line([centre, seen], RED, 1.2)
    d.line([foot, thing], GREY, 1.2, "4 3")
    d.line([centre, (centre[0], wall)], GREY, 1, "2 3")
    d.dot(thing, RED)
    d.dot(seen, RED)
    d.dot(foot, INK)
    d.text((thing[0] - 8, thing[1] + 15), "depth t", RED, "end")
    d.line([(seen[0], wall - 14), (foot[0], wall - 14)], RED, 1.4)
    d.text(((seen[0] + foot[0]) / 2, wall - 20), "shift", RED, "middle")
    d.text((centre[0] + 6, 125), "Cz", GREY)
    d.text((220, wall + 16), "distance s", GREY, "middle")
    d.text((20, 232), "shift = s t / (Cz - t): nothing of it shows in the picture itself", size=11)
    chart = Chart(d, 410, 34, 215, 150, (0, 2), (0, 0.5))
    chart.axes([0, 0.5, 1, 1.5, 2], [0, 0.1, 0.2, 0.3, 0.4, 0.5], "distance from the foot s / Cz", "shift over Cz")
    for k, (depth, colour) in enumerate(((0.2, INK), (0.1, RED), (0.05, GREEN), (0.02, BLUE))):
        d.text((418, 50 + 14 * k), f"t = {depth:g} Cz", colour, size=11)
        chart.curve([(s, s * depth / (1 - depth)) for s in (0, 2)], colour)
    return d


def surface():
    """Points in cells at a wall: the uppermost surface of each, and the cell that holds both."""
    d = Drawing(640, 235)
    draw = random.Random(5)
    place = lambda x, z: (40 + 45 * x, 190 - 11 * z)
    truth = lambda x: 2.0 + 0.15 * x if x < 5.4 else 11.0
    heights = [[] for _ in range(12)]
    for _ in range(150):
        x = draw.uniform(0, 12)
        z = truth(x) + draw.gauss(0, 0.25)
        if 5.3 < x < 5.5:
            z = draw.uniform(3, 11)
        heights[int(x)].append(z)
        d.dot(place(x, z), GREY, 1.8)
    for x in range(13):
        d.line([place(x, 0), place(x, 13)], LIGHT, 1)
    for x, all_heights in enumerate(heights):
        top = max(all_heights)
        upper = [z for z in all_heights if z > top - 1.2]
        mean = sum(upper) / len(upper)
        sigma = 0.25 / math.sqrt(len(upper))
        d.line([place(x + 0.1, mean), place(x + 0.9, mean)], RED if x == 5 else BLUE, 2.4)
        d.line([place(x + 0.5, mean - 3 * sigma), place(x + 0.5, mean + 3 * sigma)], RED if x == 5 else BLUE, 1.2)
    d.text((40, 212), "cells; grey: points; blue: surface of a cell, with three standard deviations")
    d.text((40, 228), "red: the cell of the wall takes the roof", RED)
    return d


def terrain():
    """A profile with trees and houses, its openings by growing squares, and what is taken for ground."""
    d = Drawing(640, 250)
    ground = lambda x: 6 + 5 * math.exp(-(((x - 90) / 28) ** 2)) + 0.02 * x
    objects = ((14, 24, 9.0), (34, 38, 6.0), (43, 46, 7.0), (60, 64, 5.0), (104, 118, 7.5), (130, 133, 6.0))
    low = [ground(x) + sum(h for a, b, h in objects if a <= x <= b) for x in range(150)]
    is_object = [False] * len(low)
    level, lines, radius = low, [], 1.0
    while radius <= 9:
        r = round(radius)
        opened = window(window(level, r, min), r, max)
        for k, (before, after) in enumerate(zip(level, opened)):
            is_object[k] |= before - after > 0.15 * r
        lines.append(opened)
        level, radius = opened, 1.2 * radius if 1.2 * radius > radius + 1 else radius + 1
    place = lambda x, z: (30 + 3.9 * x, 205 - 8.5 * z)
    for opened, dash in ((lines[1], "2 2"), (lines[-1], None)):
        d.line([place(x, z) for x, z in enumerate(opened)], GREEN, 1.2 if dash else 1.8, dash)
    d.line([place(x, z) for x, z in enumerate(low)], GREY, 1.3)
    for a, b, taken in runs(["g" if not o else "o" for o in is_object]):
        d.line([(place(a, 0)[0], 222), (place(b, 0)[0], 222)], BLUE if taken == "g" else RED, 6)
    d.text((30, 20), "low heights of the cells", GREY)
    d.text((200, 20), "opened by 2 cells (dotted) and by 9", GREEN)
    d.text((30, 243), "ground", BLUE)
    d.text((85, 243), "stands on it: a step of an opening took more than 0.15 r C", RED)
    return d


def window(values, r, of):
    return [of(values[max(0, k - r) : k + r + 1]) for k in range(len(values))]


def dense():
    """Costs of labels along a row, alone and summed up along the path, and the labels that win."""
    d = Drawing(640, 260)
    draw = random.Random(12)
    width, labels = 48, 16
    truth = [4 + 0.06 * x if x < 18 or x > 34 else 11.0 for x in range(width)]
    cost = [[min(24.0, 5 + 5 * abs(k - t)) + draw.uniform(-6, 6) if draw.random() > 0.3 else 18 + draw.uniform(-9, 6)
             for k in range(labels)] for t in truth]
    small, large = 4.0, 14.0

    def path(columns):
        """L(p, k) of one direction (the formula of the page)."""
        sums, last = {}, None
        for x in columns:
            if last is None:
                sums[x] = list(cost[x])
            else:
                least = min(last)
                sums[x] = [cost[x][k] + min(last[k], *(last[j] + small for j in (k - 1, k + 1) if 0 <= j < labels), least + large) - least
                           for k in range(labels)]
            last = sums[x]
        return sums

    there, back = path(range(width)), path(range(width - 1, -1, -1))
    total = [[there[x][k] + back[x][k] - cost[x][k] for k in range(labels)] for x in range(width)]
    cell = 6.0
    for left, values, words in ((15, cost, "costs of a row"), (335, total, "summed along it, both ways")):
        d.text((left, 22), words)
        flat = [v for column in values for v in column]
        shades = {}
        low, high = min(flat), sorted(flat)[int(0.9 * len(flat))]
        for x, column in enumerate(values):
            for k, v in enumerate(column):
                grey = round(255 * min(1.0, max(0.0, (v - low) / (high - low))))
                shades.setdefault(32 * round(grey / 32), []).append(f"M{left + cell * x:g} {30 + 10 * (labels - 1 - k)}h{cell:g}v10h-{cell:g}z")
        for grey, cells in sorted(shades.items()):
            if grey < 250:
                d.parts.append(f'<path d="{"".join(cells)}" fill="rgb({grey},{grey},{grey})"/>')
        d.box(left, 30, cell * width, 10 * labels)
        for x, column in enumerate(values):
            best = min(range(labels), key=lambda k: column[k])
            is_right = abs(best - truth[x]) <= 1
            d.dot((left + cell * (x + 0.5), 30 + 10 * (labels - 0.5 - best)), GREEN if is_right else RED, 2.6)
    d.text((15, 208), "upwards: labels, inverse depths of a pixel's ray;")
    d.text((15, 224), "to the right: pixels")
    d.text((335, 208), "the least is right (within a label)", GREEN)
    d.text((335, 224), "or wrong", RED)
    d.text((335, 246), f"small changes cost {small:g}, jumps {large:g}", GREY)
    return d


def systematics():
    """What four errors do to measured positions of a block: shift, offset of time, drift of a strip, bowl."""
    d = Drawing(640, 215)
    patterns = (("shift", lambda x, y, way: (0.5, 0.25)), ("time_offset", lambda x, y, way: (0.55 * way, 0.0)),
                ("drift", lambda x, y, way: (0.0, 0.7 * way * x)), ("bowl (heights)", None))
    for k, (name, moved) in enumerate(patterns):
        middle_x, middle_y = 85 + 157 * k, 105
        d.text((middle_x, 24), name, anchor="middle")
        for strip in range(4):
            way = 1 if strip % 2 == 0 else -1
            y = (strip - 1.5) / 1.5
            for image in range(6):
                x = (image - 2.5) / 2.5
                at = (middle_x + 55 * x, middle_y + 55 * y)
                if moved:
                    dx, dy = moved(x, y, way)
                    d.line([at, (at[0] + 24 * dx, at[1] - 24 * dy)], RED, 1.2, arrow=abs(dx) + abs(dy) > 0.2)
                    d.dot(at, BLUE, 2.4)
                else:
                    height = 0.55 - (x * x + y * y) / 2
                    d.dot(at, RED if height > 0 else BLUE, 1.2 + 9 * abs(height), hollow=height < 0)
    d.text((15, 205), "strips are flown to and fro; arrows: measured less true position; discs: too high, rings: too low", size=11)
    return d
