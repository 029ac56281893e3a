// SPDX-License-Identifier: Apache-2.0
// Which nodes of the cloud a view wants, and which loaded ones make room.
import type { CloudNode } from "./cloud_file";

/** Cells of a node's grid along its side: its points lie about so far apart. */
const cellsOfNode = 128;

/**
 * The nodes to be shown, the most wanted first: those that look largest, with their points in all at most `budget`, and parts only of nodes whose
 * points lie farther apart than `spacing_px`. `pixels(node)`: size of its side on the screen; 0: not seen.
 */
export function wantedNodes(nodes: CloudNode[], pixels: (node: CloudNode) => number, budget: number, spacing_px = 1.5): number[] {
  const wanted: number[] = [];
  const open: { index: number; size: number }[] = [];
  const consider = (index: number): void => {
    const size = pixels(nodes[index] as CloudNode);
    if (size > 0) insert(open, { index, size });
  };
  if (nodes.length) consider(0);
  let points = 0;
  for (let one = open.pop(); one; one = open.pop()) {
    const node = nodes[one.index] as CloudNode;
    if (points + node.points > budget && wanted.length) break;
    points += node.points;
    if (node.points > 0) wanted.push(one.index);
    if (one.size / cellsOfNode > spacing_px) node.children.forEach(consider);
  }
  return wanted;
}

/** Keeps the list sorted, the largest last. */
function insert(list: { index: number; size: number }[], one: { index: number; size: number }): void {
  let [from, to] = [0, list.length];
  while (from < to) {
    const middle = (from + to) >> 1;
    if ((list[middle] as { size: number }).size < one.size) from = middle + 1;
    else to = middle;
  }
  list.splice(from, 0, one);
}

/** Loaded nodes with when they were last seen. */
export class LeastRecentlyUsed {
  readonly #used = new Map<number, number>(); // in the order of use: index, points
  #points = 0;

  get points(): number {
    return this.#points;
  }

  use(index: number, points: number): void {
    if (!this.#used.delete(index)) this.#points += points;
    this.#used.set(index, points);
  }

  /** Takes out those that were not used for longest, but none of `kept`, until at most `budget` points are left. */
  evicted(budget: number, kept: Set<number>): number[] {
    const out: number[] = [];
    for (const [index, points] of this.#used) {
      if (this.#points <= budget) break;
      if (kept.has(index)) continue;
      this.#used.delete(index);
      this.#points -= points;
      out.push(index);
    }
    return out;
  }
}
