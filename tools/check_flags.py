#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when a text below the module app spells a flag of the command line ("--max-error-px"), or when an error names an
option ("max_error_px"_option) that no options struct and no command has.

Errors carry the names of fields (base/result.h); each face spells them as its users type them.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent / "src" / "collinea"
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
TEXT = re.compile(r'"(?:\\.|[^"\\\n])*"')
FLAG = re.compile(r"(?<![\w-])--[a-z][a-z0-9-]+")
OTHER_PROGRAMS = {"--file"}  # of projsync, in advice about missing grids


def without_raw_texts(text):
    """Raw string literals hold style sheets and data; their line breaks are kept."""
    return re.sub(r'R"(\w*)\(.*?\)\1"', lambda found: "\n" * found[0].count("\n"), text, flags=re.S)


def main():
    bad, named, known = [], [], set()
    for path in sorted(ROOT.rglob("*.[hc]*")):
        if path.name.endswith("_test.cc"):
            continue
        text = COMMENT.sub("", without_raw_texts(path.read_text()))
        known |= set(re.findall(r'Field\{\s*"(\w+)"', text)) | set(re.findall(r'\.(?:add|required)\((?:"-o", )?"(\w+)"', text))
        named += [(path, name) for name in re.findall(r'"(\w+)"_option', text)]
        if path.relative_to(ROOT).parts[0] == "app":
            continue
        for number, line in enumerate(text.splitlines(), 1):
            for literal in TEXT.findall(line):
                for flag in FLAG.findall(literal):
                    if flag not in OTHER_PROGRAMS:
                        bad.append(f"{path}:{number}: {flag} is spelled below app")
    bad += [f"{path}: no option is called {name}" for path, name in named if name not in known]
    print("\n".join(bad) or f"no flag is spelled below app; {len(named)} options are named in errors")
    sys.exit(bool(bad))


if __name__ == "__main__":
    main()
