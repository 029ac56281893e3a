#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""refine_time.py PROGRAM PROJECT IMAGE X Y [TIMES]: time of one POST /refine of `collinea serve`, asked alone, at a position of an image of a project.

Prints median and largest of clock and processor time, and what was found. PROJECT needs photographs alone.
"""
import json
import pathlib
import statistics
import sys
import time

from serve_kills import Server

TICK = 0.01


def processor_seconds(pid):
    words = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(words[11]) + int(words[12])) * TICK


def main():
    program, project, image, x, y = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4]), float(sys.argv[5])
    times = int(sys.argv[6]) if len(sys.argv) > 6 else 20
    server = Server(program, project)
    ask = lambda: server.ask("POST", f"/api/projects/{server.id}/refine", {"image": image, "pixel": [x, y], "kind": "auto"})
    answer = ask()
    before, clock = processor_seconds(server.process.pid), []
    for _ in range(times):
        began = time.monotonic()
        answer = ask()
        clock.append(1e3 * (time.monotonic() - began))
    cpu = 1e3 * (processor_seconds(server.process.pid) - before) / times
    server.kill()
    print(f"clock: median {statistics.median(clock):.0f} ms, largest {max(clock):.0f} ms; processor: mean {cpu:.0f} ms")
    print(answer[0].status, json.loads(answer[1]))


if __name__ == "__main__":
    main()
