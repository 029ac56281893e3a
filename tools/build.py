#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Builds targets of a preset and shows how far that is and how long it will take.

usage: tools/build.py [--preset release] [--jobs N] TARGET...
What the compiler says is passed on as it is. The time left is judged by the lines of source text that are left, which tells more
than the number of files when some of these are groups.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
FINISHED = re.compile(r"^@@(\d+)/(\d+) (.*)$")
LINES_EACH = 400  # of reading headers and writing the object, in lines of source that take as long


def lines_of(path):
    try:
        return pathlib.Path(path).read_bytes().count(b"\n")
    except OSError:
        return 0


def work_of_objects(folder):
    """How much there is to compile for each object, by its name, in lines."""
    work = {}
    database = subprocess.run(["ninja", "-C", folder, "-t", "commands"], capture_output=True, text=True).stdout
    for command in re.finditer(r" -o (\S+\.o) -c (\S+)$", database, re.M):
        source = command[2]
        members = re.findall(r'^#include "(/[^"]+)"', pathlib.Path(source).read_text(), re.M) if "/Unity/" in source else [source]
        work[command[1]] = LINES_EACH + sum(lines_of(member) for member in members)
    return work


def clock(seconds):
    return f"{int(seconds) // 60}:{int(seconds) % 60:02d}"


class Progress:
    """One line that is written over on a terminal, a line every half minute elsewhere."""

    def __init__(self, work):
        self.work, self.started, self.shown = work, time.monotonic(), 0.0
        self.terminal = sys.stdout.isatty()
        self.done_work, self.all_work, self.missing = 0, 0, 0

    def finished(self, done, steps, what):
        found = re.search(r"(\S+\.o)$", what)
        self.done_work += self.work.get(found[1], 0) if found else 0
        seconds = time.monotonic() - self.started
        most_is_new = self.all_work > 0 and self.missing > 0.6 * steps  # else what is out of date would not be counted
        share = min(self.done_work / self.all_work, 0.999) if most_is_new and done < steps else done / steps
        left = f"about {clock(seconds * (1 - share) / share)} left" if share > 0.02 and seconds > 5 else "how long: soon known"
        text = f"   building: {100 * share:3.0f} %, step {done} of {steps}, {clock(seconds)} gone, {left if done < steps else 'done'}"
        if self.terminal:
            print("\r\033[K" + text, end="\n" if done == steps else "", flush=True)
        elif done == steps or seconds - self.shown >= 30 or done == 1:
            self.shown = seconds
            print(text, flush=True)

    def other(self, line):
        print(("\r\033[K" if self.terminal else "") + line, flush=True)


def missing_objects(folder, targets):
    """The objects below the targets that have never been made."""
    inputs = subprocess.run(["ninja", "-C", folder, "-t", "inputs", *(targets or ["all"])], capture_output=True, text=True).stdout
    return [name for name in inputs.split() if name.endswith(".o") and not os.path.exists(os.path.join(folder, name))]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--preset", default="release")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 2)
    parser.add_argument("targets", nargs="*")
    args = parser.parse_args()
    folder = str(ROOT / "build" / args.preset)
    progress = Progress(work_of_objects(folder))
    missing = missing_objects(folder, args.targets)
    progress.all_work, progress.missing = sum(progress.work.get(name, 0) for name in missing), len(missing)
    with subprocess.Popen(["ninja", "-C", folder, "-j", str(args.jobs), *args.targets], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, env={**os.environ, "NINJA_STATUS": "@@%f/%t "}) as ninja:
        for line in ninja.stdout:
            line = line.rstrip("\n")
            if found := FINISHED.match(line):
                progress.finished(int(found[1]), int(found[2]), found[3])
            elif line and not line.startswith("ninja: Entering directory"):
                progress.other(line)
    sys.exit(ninja.returncode)


if __name__ == "__main__":
    main()
