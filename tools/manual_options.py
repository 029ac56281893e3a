#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the option tables of docs/manual from `collinea COMMAND --help`, so that the program tells them once.

usage: tools/manual_options.py [--check] [--collinea PROGRAM]
  --check     change nothing; fail when a page is not up to date
  --collinea  the program (default build/release/bin/collinea)
Each page docs/manual/COMMAND.md holds two marker lines; what stands between them is replaced.
"""
import argparse
import pathlib
import re
import subprocess
import sys

BEGIN = "<!-- options: made by tools/manual_options.py -->"
END = "<!-- options: end -->"
ROOT = pathlib.Path(__file__).resolve().parent.parent
# "  --max-error-px FLOAT=2.5    largest distance [px]"; the help may stand alone on the next line.
OPTION = re.compile(r"^  (?P<names>-\S+)(?: (?P<type>[A-Z]+)(?:=(?P<default>\S+))?)?(?P<required> REQUIRED)?(?:\s+(?P<help>.*))?$")
POSITIONAL = re.compile(r"^  (?P<names>[a-z]+) (?P<type>[A-Z]+)(?: \.\.\.)?(?P<required> REQUIRED)?(?:\s+(?P<help>.*))?$")


def help_of(program, command):
    """The help text of a command, or of the program where none is named, long lines unbroken."""
    done = subprocess.run([program, *([command] if command else []), "--help"], stdout=subprocess.PIPE, text=True)
    if done.returncode:
        sys.exit(f"{program} {command} --help failed")
    lines = []
    for line in done.stdout.splitlines():
        if lines and re.match(r"^ {20,}\S", line):
            lines[-1] += "  " + line.strip()
        else:
            lines.append(line.rstrip())
    return lines


def cells(match):
    """(option, value, unit, default, meaning) of one line of help."""
    names, value = match["names"], (match["type"] or "").lower()
    text, default, unit = match["help"] or "", match.groupdict().get("default") or "", ""
    if "{false}" in names:  # a flag with its opposite
        names, value = names.replace("{false}", ""), "flag"
    if found := re.search(r" \(default: (yes|no)\)$", text):
        default, text = found[1], text[: found.start()]
    if found := re.search(r" \[([^\]]+)\]$", text):
        unit, text = found[1], text[: found.start()]
    if match["required"]:
        default = "required"
    option = ", ".join(f"`{name}`" for name in names.split(","))
    return option, value, unit, default, text


def table(rows):
    head = ["| option | value | unit | default | meaning |", "|---|---|---|---|---|"]
    return head + ["| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |" for row in rows]


def options_of(program, command):
    groups, group = [], None
    for line in help_of(program, command):
        if title := re.match(r"^(\w+):$", line):
            group = (title[1], [])
            groups.append(group)
        elif group:
            match = (POSITIONAL if group[0] == "Positionals" else OPTION).match(line)
            if match and "--help" not in match["names"]:
                group[1].append(cells(match))
    names = {"Positionals": "Arguments", "Options": "General"}
    text = []
    for name, rows in groups:
        if rows:
            text += ["", f"**{names.get(name, name)}**", "", *table(rows)]
    return "\n".join([BEGIN, *text, "", END])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--collinea", default=str(ROOT / "build/release/bin/collinea"))
    args = parser.parse_args()
    stale = []
    for page in sorted((ROOT / "docs/manual").glob("*.md")):
        text = page.read_text()
        if BEGIN not in text:
            continue
        if END not in text:
            sys.exit(f"{page}: no line {END} behind the table of options")
        before, rest = text.split(BEGIN, 1)
        after = rest.split(END, 1)[1]
        new = before + options_of(args.collinea, page.stem) + after
        if new != text:
            stale.append(page.name)
            if not args.check:
                page.write_text(new)
    print(("not up to date: " if args.check else "changed: ") + ", ".join(stale) if stale else "manual pages are up to date")
    sys.exit(bool(stale) and args.check)


if __name__ == "__main__":
    main()
