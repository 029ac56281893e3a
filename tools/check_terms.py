#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds retired words in the identifiers of the source: one word for one thing, and it is the one of the field. Prints each
with the word to use; fails when there is any. Names of tests are sentences and are not looked at, nor are comments and texts,
except for the words of SENTENCES; names of files in docs/theory must be those of files."""
import pathlib, re, sys

# A part of any identifier (snake_case or CamelCase).
PARTS = {
    "picture": "image", "pictures": "images", "photograph": "image", "photographs": "images", "foretold": "predicted", "foretell": "predict",
    "blunder": "gross_error", "blunders": "gross_errors", "place": "index, position or location", "places": "indices, positions or samples",
    "speck": "speckle", "specks": "speckles", "sounding": "depth_sample", "soundings": "depth_samples", "hinge": "articulation_image",
    "hinges": "articulation_images", "gone": "rejected or removed", "pulled": "influence", "astray": "diverges", "cure": "remedy", "cures": "remedies",
    "told": "stated, reported or determined", "taken_out": "rejected", "use_ground": "use_geodetic", "additional_held": "additional_fixed",
    "by_turn": "by_rotation", "turn_rad": "rotation_rad", "turn_sigma": "rotation_sigma", "first_extra": "first_auxiliary",
    "ground_observation": "geodetic_observation", "ground_kind": "geodetic_kind", "least_blunder": "minimal_detectable_bias",
}
# A whole identifier in some modules alone.
WITHIN = {
    ("adjust", "quality"): {
        "held": "is_fixed", "border": "global_count, first_global", "joined": "first_retained, retained_points", "extra": "auxiliary",
        "extras": "auxiliaries", "turn": "rotation", "beside": "off_diagonal_weight",
    },
}
ALLOWED = {"in_place_index", "in_place_type", "in_place", "transposeInPlace"}
SENTENCES = {"foretold": "predicted", "goes astray": "diverges"}
TOKEN = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:[^"\\\n]|\\.)*"|(?<![0-9a-fA-F])\'(?:[^\'\\\n]|\\.)+\'|\b(?:TYPED_)?TEST(?:_[FP])?\([^)]*\)|#\s*include[^\n]*|[A-Za-z_]\w*', re.S)
PART = re.compile(r"(?<![a-z])(" + "|".join(sorted(PARTS, key=len, reverse=True)) + r")(?![a-z])")


def retired(module, path):
    """(line, word, what to say instead) of a file."""
    source = path.read_text()
    within = {}
    for modules, words in WITHIN.items():
        if module in modules and not path.name.endswith("_test.cc"):
            within.update(words)
    for match in TOKEN.finditer(source):
        token = match[0]
        found = None
        if re.match(r"[A-Za-z_]\w*$", token):
            snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", token).lower()
            part = PART.search(snake)
            if token in within:
                found = within[token]
            elif part and token not in ALLOWED:
                found = PARTS[part[1]]
        elif token.startswith(('"', 'R"')):
            token = next((word for word in SENTENCES if word in token), None)
            found = SENTENCES.get(token)
        if found:
            yield source.count("\n", 0, match.start()) + 1, token, found


def missing_files(top):
    """(page, name) of sources that a page of the theory names and that are not there."""
    have = {path.name for folder in ("src", "fuzz", "bench", "tools") for path in (top / folder).rglob("*.*")}
    for page in sorted((top / "docs" / "theory").glob("*.md")):
        for name in re.findall(r"`(?:\w+/)*(\w+\.(?:cc|h|py|sh))`", page.read_text()):
            if name not in have:
                yield page, name


if __name__ == "__main__":
    root = pathlib.Path(__file__).resolve().parent.parent / "src" / "collinea"
    count = 0
    for path in sorted(root.rglob("*.[hc]*")):
        for line, word, instead in retired(path.relative_to(root).parts[0], path):
            print(f"{path.relative_to(root)}:{line}: {word}: {instead}")
            count += 1
    for page, name in missing_files(root.parent.parent):
        print(f"{page.name}: {name}: there is no such file")
        count += 1
    print(f"{count} retired words in identifiers, and names of files that are gone in docs/theory")
    sys.exit(count > 0)
