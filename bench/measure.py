# SPDX-License-Identifier: Apache-2.0
"""What a command costs: processor time, wall time and peak memory of one child process."""
import dataclasses
import os
import statistics
import subprocess
import sys
import time


@dataclasses.dataclass
class Cost:
    cpu_s: float = 0  # user + system
    wall_s: float = 0
    peak_bytes: int = 0

    def __add__(self, other):
        """One after the other."""
        return Cost(self.cpu_s + other.cpu_s, self.wall_s + other.wall_s, max(self.peak_bytes, other.peak_bytes))


def run(words, log=None, environment=None):
    """Runs a command to its end; its output goes to the file `log` or to our stderr. Stops everything if it fails."""
    words = [str(w) for w in words]
    start = time.time()
    sink = open(log, "ab") if log else sys.stderr
    child = subprocess.Popen(words, stdout=sink, stderr=sink, env={**os.environ, **(environment or {})})
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if log:
        sink.close()
    if child.returncode:
        sys.exit(f"FAILED ({child.returncode}): {' '.join(words)}" + (f", see {log}" if log else ""))
    return Cost(usage.ru_utime + usage.ru_stime, time.time() - start, usage.ru_maxrss * 1024)


def median_cost(costs):
    return Cost(*(statistics.median(getattr(c, f.name) for c in costs) for f in dataclasses.fields(Cost)))


def row(*cells):
    print("| " + " | ".join(str(c) for c in cells) + " |", flush=True)


def head(*cells):
    row(*cells)
    row(*("---" for _ in cells))
