#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every test that docs/theory/worked-numbers.md names (`Suite.Test`) must be one of the source. Prints those that are none."""
import pathlib, re, sys

top = pathlib.Path(__file__).resolve().parent.parent
PAGE = top / "docs" / "theory" / "worked-numbers.md"
DEFINED = re.compile(r"\b(?:TYPED_)?TEST(?:_[FP])?\(\s*(\w+),\s*(\w+)\s*\)")


def tests():
    return {f"{suite}.{name}" for path in (top / "src").rglob("*_test.cc") for suite, name in DEFINED.findall(path.read_text())}


def named(page):
    return re.findall(r"`([A-Z]\w+\.[A-Z]\w+)`", page)


def main():
    defined, names = tests(), named(PAGE.read_text())
    missing = sorted(set(names) - defined)
    for name in missing:
        print(f"{PAGE.relative_to(top)}: no test {name}")
    print(f"{len(set(names))} tests named in {PAGE.name}, {len(missing)} of them missing")
    return 1 if missing or not names else 0


if __name__ == "__main__":
    sys.exit(main())
