#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Line coverage of the tests, by module: reads the counters that a run of build/coverage left, with gcov.

A line counts once, however many instantiations of a template it has; it is covered when one of them ran. Test files and
helpers of tests (test_*.h) do not count. Prints a Markdown table; with --missed MODULE the files of that module and
their lines that never ran.
"""
import argparse, collections, json, pathlib, re, subprocess, sys
from concurrent.futures import ThreadPoolExecutor

root = pathlib.Path(__file__).resolve().parent.parent
source = root / "src" / "collinea"


def counted(path):
    """Whether lines of this file count."""
    name = path.name
    return path.is_relative_to(source) and not name.endswith(("_test.cc", "_bench.cc")) and not name.startswith("test_")


def lines_of(notes):
    """(file, line, times it ran) of everything that one object file was made from."""
    made = subprocess.run(["gcov", "--json-format", "--stdout", str(notes)], capture_output=True, cwd=notes.parent, check=True)
    for text in made.stdout.splitlines():
        for file in json.loads(text)["files"]:
            path = pathlib.Path(notes.parent, file["file"]).resolve()
            if counted(path):
                for line in file["lines"]:
                    yield path, line["line_number"], line["count"]


def collected(build, jobs):
    runs = collections.defaultdict(lambda: collections.defaultdict(int))
    # Notes without counters: nothing of that object ever ran; its lines count all the same.
    notes = sorted(build.rglob("*.gcno"))
    with ThreadPoolExecutor(jobs) as pool:
        for found in pool.map(lambda one: list(lines_of(one)), notes):
            for path, line, count in found:
                runs[path][line] += count
    return runs


def share(lines):
    hit, total = sum(count > 0 for count in lines), len(lines)
    return hit, total, 100 * hit / total if total else 100.0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--build", type=pathlib.Path, default=root / "build" / "coverage")
    parser.add_argument("--missed", metavar="MODULE")
    parser.add_argument("--jobs", type=int, default=2)
    asked = parser.parse_args()
    runs = collected(asked.build, asked.jobs)
    if not runs:
        sys.exit(f"no counters in {asked.build}: run tools/coverage.sh")
    if asked.missed:
        for path in sorted(path for path in runs if path.parent.relative_to(source).parts[0] == asked.missed):
            missed = [line for line, count in sorted(runs[path].items()) if count == 0]
            hit, total, percent = share(runs[path].values())
            print(f"{path.relative_to(root)}: {percent:.1f} % of {total}; never ran: {' '.join(map(str, missed))}")
        return
    modules = re.findall(r"add_subdirectory\((\w+)\)", (source / "CMakeLists.txt").read_text())
    by_module = {module: [] for module in modules}
    for path, lines in runs.items():
        by_module.setdefault(path.relative_to(source).parts[0], []).extend(lines.values())
    print("| module | lines | covered | % |\n|---|---:|---:|---:|")
    for module, lines in by_module.items():
        if not lines:  # not built
            continue
        hit, total, percent = share(lines)
        print(f"| {module} | {total} | {hit} | {percent:.1f} |")
    hit, total, percent = share([count for lines in by_module.values() for count in lines])
    print(f"| **all** | **{total}** | **{hit}** | **{percent:.1f}** |")


if __name__ == "__main__":
    main()
