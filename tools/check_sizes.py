#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Lengths of functions and classes under src/collinea, in lines.

usage: tools/check_sizes.py [--list N]
Fails when a function outside tests is longer than 80 lines, when one in a hundred is longer than 45, or when a class has more than
250 lines. --list N also prints the N longest of each.
"""
import argparse
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent / "src" / "collinea"
MOST_LINES, MOST_LINES_P99, MOST_CLASS_LINES = 80, 45, 250
NOISE = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'|^[ \t]*#(?:\\\n|[^\n])*', re.S | re.M)


def blanked(text):
    """The text without comments, strings and preprocessor lines, every line break kept; digit separators are no quotes."""
    text = re.sub(r"(?<=\d)'(?=\d)", "", text)
    return NOISE.sub(lambda found: "\n" * found[0].count("\n") + " ", text)


def kind_of(head):
    """What the block after `head` is: namespace, class, function, or other."""
    head = head.strip()
    if re.match(r"(inline\s+)?namespace\b|extern\b", head):
        return "namespace"
    if re.match(r"(template\s*<.*>\s*)?(class|struct|union)\b", head, re.S) and "(" not in re.sub(r"alignas\([^)]*\)", "", head):
        return "class"
    if re.match(r"(typedef\s+)?enum\b", head) or not head.endswith((")", "const", "noexcept", "override", "final")) and "->" not in head and not re.search(r"\)\s*:", head):
        return "other"
    return "function" if "(" in head and "=" not in re.sub(r"operator\s*\W+|\([^()]*\)|<[^<>]*>|[<>=!]=", "", head) else "other"


def blocks(path):
    """(kind, name, lines, first line) of all functions and classes of a file."""
    text = blanked(path.read_text())
    stack, head, found = [], 0, []
    for at, sign in enumerate(text):
        if sign == "{":
            outer = [kind for kind, *_ in stack]
            inside = all(kind in ("namespace", "class") for kind in outer)
            words = text[head:at]
            kind = kind_of(re.sub(r"^\s*(public|private|protected)\s*:", "", words)) if inside else "other"
            begin = head + len(words) - len(words.lstrip())
            stack.append((kind, " ".join(words.split())[-90:], begin))
            head = at + 1
        elif sign == "}" and stack:
            kind, name, begin = stack.pop()
            if kind in ("function", "class"):
                first = text.count("\n", 0, begin) + 1
                found.append((kind, name, text.count("\n", begin, at) + 1, first))
            if kind != "other" or all(outer in ("namespace", "class") for outer, *_ in stack):
                head = at + 1
        elif sign == ";" and all(kind in ("namespace", "class") for kind, *_ in stack):
            head = at + 1
    return found


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--list", type=int, default=0)
    args = parser.parse_args()
    sizes = {"function": [], "class": []}
    for path in sorted(ROOT.rglob("*.[hc]*")):
        if not path.stem.endswith("_test"):
            for kind, name, lines, first in blocks(path):
                sizes[kind].append((lines, f"{path.relative_to(ROOT)}:{first}: {name}"))
    for kind in sizes:
        sizes[kind].sort(reverse=True)
        for lines, where in sizes[kind][: args.list]:
            print(f"{lines:5} {where}")
    functions, classes = sizes["function"], sizes["class"]
    p99, median = functions[len(functions) // 100][0], functions[len(functions) // 2][0]
    p90 = functions[len(functions) // 10][0]
    print(f"{len(functions)} functions: p50 {median}, p90 {p90}, p99 {p99}, longest {functions[0][0]} lines; "
          f"{len(classes)} classes, longest {classes[0][0]} lines")
    long = [f"{lines} lines: {where}" for lines, where in functions if lines > MOST_LINES]
    long += [f"{lines} lines: {where}" for lines, where in classes if lines > MOST_CLASS_LINES]
    print("\n".join(long), end="\n" if long else "")
    sys.exit(bool(long) or p99 > MOST_LINES_P99)


if __name__ == "__main__":
    main()
