# SPDX-License-Identifier: Apache-2.0
"""A small SVG drawing: lines, curves, marks, words, axes. Positions are in the unit of the drawing, y downwards."""
import math

BLUE, RED, GREEN, GREY, INK, LIGHT = "#1b6ca8", "#b03a2e", "#2e7d32", "#777", "#222", "#e4e8ee"


def number(value):
    return f"{value:.1f}".rstrip("0").rstrip(".").replace("-0", "0") if abs(value) < 0.05 else f"{value:.1f}".removesuffix(".0")


class Drawing:
    def __init__(self, width, height):
        self.head = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">\n'
                     f'<rect width="{width}" height="{height}" fill="#fff"/>\n')
        self.marks, self.parts = {}, []

    def line(self, points, colour=INK, width=1.5, dash=None, arrow=False, fill="none", opacity=None, close=False):
        """Through points; an arrow head stands at its end."""
        path = "M" + "L".join(f"{number(x)} {number(y)}" for x, y in points) + ("Z" if close else "")
        more = f' stroke-dasharray="{dash}"' if dash else ""
        if arrow:
            name = self.marks.setdefault(colour, f"a{len(self.marks)}")
            more += f' marker-end="url(#{name})"'
        if opacity is not None:
            more += f' fill-opacity="{opacity}"'
        self.parts.append(f'<path d="{path}" fill="{fill}" stroke="{colour}" stroke-width="{width}"{more}/>')

    def dot(self, at, colour=INK, radius=3, hollow=False):
        look = f'fill="#fff" stroke="{colour}" stroke-width="1.3"' if hollow else f'fill="{colour}"'
        self.parts.append(f'<circle cx="{number(at[0])}" cy="{number(at[1])}" r="{radius}" {look}/>')

    def box(self, left, top, width, height, colour=GREY, fill="none", opacity=None, line=1.2):
        more = f' fill-opacity="{opacity}"' if opacity is not None else ""
        self.parts.append(f'<rect x="{number(left)}" y="{number(top)}" width="{number(width)}" height="{number(height)}" '
                          f'fill="{fill}" stroke="{colour}" stroke-width="{line}"{more}/>')

    def text(self, at, words, colour=INK, anchor="start", size=None, italic=False):
        words = words.replace("&", "&amp;").replace("<", "&lt;")
        more = (f' font-size="{size}"' if size else "") + (' font-style="italic"' if italic else "")
        more += f' text-anchor="{anchor}"' if anchor != "start" else ""
        self.parts.append(f'<text x="{number(at[0])}" y="{number(at[1])}" fill="{colour}"{more}>{words}</text>')

    def finish(self):
        heads = "".join(f'<marker id="{name}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" orient="auto">'
                        f'<path d="M0 0L8 4L0 8z" fill="{colour}"/></marker>' for colour, name in self.marks.items())
        return self.head + (f"<defs>{heads}</defs>\n" if heads else "") + "\n".join(self.parts) + "\n</svg>\n"


class Chart:
    """Axes of a box of the drawing: position in it of a pair of values."""

    def __init__(self, drawing, left, top, width, height, x, y, logarithmic=False):
        self.drawing, self.box, self.x, self.y, self.logarithmic = drawing, (left, top, width, height), x, y, logarithmic

    def at(self, x, y):
        left, top, width, height = self.box
        low, high = self.y
        if self.logarithmic:
            y, low, high = math.log(y), math.log(low), math.log(high)
        return left + width * (x - self.x[0]) / (self.x[1] - self.x[0]), top + height * (1 - (y - low) / (high - low))

    def axes(self, ticks_x, ticks_y, title_x, title_y, words=str):
        left, top, width, height = self.box
        for x in ticks_x:
            column = self.at(x, self.y[0])[0]
            self.drawing.line([(column, top), (column, top + height)], LIGHT, 1)
            self.drawing.text((column, top + height + 14), words(x), GREY, "middle", 11)
        for y in ticks_y:
            row = self.at(self.x[0], y)[1]
            self.drawing.line([(left, row), (left + width, row)], LIGHT, 1)
            self.drawing.text((left - 5, row + 4), f"{y:g}", GREY, "end", 11)
        self.drawing.box(left, top, width, height)
        self.drawing.text((left + width / 2, top + height + 30), title_x, INK, "middle")
        self.drawing.text((left, top - 7), title_y)

    def curve(self, points, colour=BLUE, width=1.6, dash=None):
        self.drawing.line([self.at(x, y) for x, y in points], colour, width, dash)

    def dots(self, points, colour=BLUE, radius=3, hollow=False):
        for x, y in points:
            self.drawing.dot(self.at(x, y), colour, radius, hollow)


class View:
    """Parallel projection of space (x right, y away, z up) onto the drawing."""

    def __init__(self, left, top, scale, turn_deg=25, down_deg=25):
        self.left, self.top, self.scale = left, top, scale
        self.turn, self.down = math.radians(turn_deg), math.radians(down_deg)

    def __call__(self, x, y, z):
        right = math.cos(self.turn) * x - math.sin(self.turn) * y
        away = math.sin(self.turn) * x + math.cos(self.turn) * y
        return self.left + self.scale * right, self.top - self.scale * (math.cos(self.down) * z + math.sin(self.down) * away)


def steps(low, high, count):
    return [low + (high - low) * k / count for k in range(count + 1)]


def middle(a, b, share=0.5):
    return tuple(p + share * (q - p) for p, q in zip(a, b))
