#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Makes figures of the theory pages from their formulas, or from tables of the pages: tools/figures.py [--check] [NAME...]

--check: says which files are not what would be made. Figures that are not listed here were drawn by hand or written by the program.
"""
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools" / "figures"))
import estimation  # noqa: E402
import images  # noqa: E402
import orientation  # noqa: E402
import products  # noqa: E402

FIGURES = {
    "adjustment": estimation.adjustment,
    "camera": estimation.camera,
    "dense": products.dense,
    "factorisation": orientation.factorisation,
    "frames": orientation.frames,
    "laz": orientation.laz,
    "least-squares-matching": images.least_squares_matching,
    "matching": orientation.matching,
    "multi-image-matching": images.multi_image_matching,
    "orientation": orientation.orientation,
    "orthophoto": products.orthophoto,
    "pair": images.pair,
    "planning": estimation.planning,
    "real_pairs": orientation.real_pairs,
    "rectification": products.rectification,
    "relaxation": images.relaxation,
    "reliability": estimation.reliability,
    "resection": orientation.resection,
    "sift": images.sift,
    "stereo": images.stereo,
    "surface": products.surface,
    "synthetic": orientation.synthetic,
    "systematics": products.systematics,
    "tags": images.tags,
    "terrain": products.terrain,
    "two-view": orientation.two_view,
}


def main():
    check = "--check" in sys.argv
    names = [name for name in sys.argv[1:] if not name.startswith("--")] or list(FIGURES)
    stale = []
    for name in names:
        path = ROOT / "docs" / "theory" / "figures" / f"{name}.svg"
        text = FIGURES[name]().finish()
        if not check:
            path.write_text(text)
        elif not path.exists() or path.read_text() != text:
            stale.append(name)
    if stale:
        sys.exit("figures out of date (tools/figures.py makes them): " + ", ".join(stale))


if __name__ == "__main__":
    main()
