#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fails when units include each other in a circle. A unit is a header with the source of the same name; tests are none."""
import pathlib, re, sys

root = pathlib.Path(__file__).resolve().parent.parent / "src"
include = re.compile(r'^\s*#include "(collinea/[^"]+)"', re.MULTILINE)


def unit_of(path):
    return str(pathlib.PurePath(path).with_suffix("")).removeprefix("collinea/")


def units():
    """The units that each unit includes."""
    edges = {}
    for path in sorted(root.rglob("*.[hc]*")):
        if path.suffix in (".h", ".cc") and not path.stem.endswith("_test"):
            own = unit_of(path.relative_to(root))
            edges.setdefault(own, set()).update(unit_of(name) for name in include.findall(path.read_text()))
    return {unit: sorted(other for other in found if other in edges and other != unit) for unit, found in edges.items()}


def circles(edges):
    """Strongly connected components of more than one unit (Tarjan 1972, without recursion)."""
    index, low, stack, found = {}, {}, [], []
    for start in edges:
        work = [] if start in index else [(start, iter(edges[start]))]
        if work:
            index[start] = low[start] = len(index)
            stack.append(start)
        while work:
            unit, others = work[-1]
            other = next((o for o in others if o not in index or o in stack), None)
            if other is None:
                work.pop()
                if work:
                    low[work[-1][0]] = min(low[work[-1][0]], low[unit])
                if low[unit] == index[unit]:
                    at = stack.index(unit)
                    if len(stack) - at > 1:
                        found.append(sorted(stack[at:]))
                    del stack[at:]
            elif other in index:
                low[unit] = min(low[unit], index[other])
            else:
                index[other] = low[other] = len(index)
                stack.append(other)
                work.append((other, iter(edges[other])))
    return found


def main():
    edges = units()
    found = circles(edges)
    for circle in found:
        print(f"circle of {len(circle)} units:")
        for unit in circle:
            print(f"  {unit} -> {', '.join(o for o in edges[unit] if o in circle)}")
    if not found:
        print(f"{len(edges)} units, no circles")
    return bool(found)


if __name__ == "__main__":
    sys.exit(main())
