#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Finds retired words: one word for one thing, and it is the one of the field. Prints each with the word to use; fails when
there is any. Three things are looked over:
- identifiers of the source, whole and in parts (PARTS, WITHIN). Names of tests are sentences and are not looked at;
- comments and texts of the source, README.md, ARCHITECTURE.md, docs/manual and docs/theory, for PHRASES: only those which have
  no other meaning here, also where a line breaks within one. What reads well in one sentence and not in another (a place, what
  is said, a room) is for readers to find. docs/decisions are history and stay as they were written;
- names of files in docs/theory: they must be those of files."""
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
# Regular expressions of whole words; a blank stands for any blanks, line breaks and signs of comments.
PHRASES = {
    r"foretold|foretell(s|ing)?": "predicted, predict", r"(goes|go|went|gone) astray": "diverges", r"specks?": "speckles", r"cure[sd]?": "remedy",
    r"(taken|takes|took|taking) out": "rejected, removed", r"hinges?": "articulation images", r"soundings?": "depth samples", r"false rims?": "foreground fattening",
    r"least (detectable )?blunders?": "minimal detectable bias", r"weak observations?": "pseudo-observations, prior", r"made nothing": "skipped",
    r"held fixed": "fixed", r"(is|are|was|were) told(?! (apart|from))": "reported, stated", r"without (a )?place(?! on Earth)": "without georeference",
}
TOKEN = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:[^"\\\n]|\\.)*"|(?<![0-9a-fA-F])\'(?:[^\'\\\n]|\\.)+\'|\b(?:TYPED_)?TEST(?:_[FP])?\([^)]*\)|#\s*include[^\n]*|[A-Za-z_]\w*', re.S)
PHRASE = {re.compile(r"\b(" + phrase.replace(" ", r"(?:\s|//[/<]?)+") + r")\b", re.I): instead for phrase, instead in PHRASES.items()}
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
        if found:
            yield source.count("\n", 0, match.start()) + 1, token, found


def phrases(path):
    """(line, phrase, what to say instead) in the comments and texts of a source, or in a page."""
    text = path.read_text()
    for phrase, instead in PHRASE.items():
        for match in phrase.finditer(text):
            yield text.count("\n", 0, match.start()) + 1, " ".join(match[0].split()), instead


def pages(top):
    return [top / "README.md", top / "ARCHITECTURE.md", *(top / "docs" / "manual").glob("*.md"), *(top / "docs" / "theory").glob("*.md")]


def missing_files(top):
    """(page, name) of sources that a page of the theory names and that are not there."""
    have = {path.name for folder in ("src", "fuzz", "bench", "tools") for path in (top / folder).rglob("*.*")}
    for page in sorted((top / "docs" / "theory").glob("*.md")):
        for name in re.findall(r"`(?:\w+/)*(\w+\.(?:cc|h|py|sh))`", page.read_text()):
            if name not in have:
                yield page, name


if __name__ == "__main__":
    top = pathlib.Path(__file__).resolve().parent.parent
    root = top / "src" / "collinea"
    sources = sorted(root.rglob("*.[hc]*"))
    found = [(path, *one) for path in sources for one in retired(path.relative_to(root).parts[0], path)]
    found += [(path, *one) for path in sources + sorted(pages(top)) for one in phrases(path)]
    for path, line, word, instead in found:
        print(f"{path.relative_to(top)}:{line}: {word}: {instead}")
    missing = list(missing_files(top))
    for page, name in missing:
        print(f"{page.name}: {name}: there is no such file")
    print(f"{len(found)} retired words, {len(missing)} names of files that are gone in docs/theory")
    sys.exit(bool(found or missing))
