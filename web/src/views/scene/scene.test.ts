// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { drawing } from "../../lib/drawing.svelte";
import type { CloudRegion, ImageInfo } from "../../lib/types";
import { levelSize, wantedPictures } from "./camera_pictures";
import { type CloudHeader, type CloudNode, tree } from "./cloud_file";
import { sigmaCode, sigmaOfCode } from "./messages";
import { LeastRecentlyUsed, wantedNodes } from "./octree";
import { editedClass } from "./regions";
import { RegionDraft } from "./region_draft.svelte";
import { cross, dot, sum, type Triple, Viewpoint } from "./viewpoint";

const square: [number, number][] = [[0, 0], [4, 0], [4, 4], [0, 4]];
const region = (action: CloudRegion["action"], more: Partial<CloudRegion> = {}): CloudRegion => ({ action, class: null, ring: square, low_m: null, high_m: null, ...more });

test("edits come one after the other, and heights of their ends belong to them", () => {
  const edits = [region("classify", { class: 6 }), region("classify", { class: 2, high_m: 1 }), region("cut", { low_m: 5, high_m: 6 })];
  expect([0, 1, 2, 5, 6, 7].map((h) => editedClass(edits, 0, 1, 1, h))).toEqual([2, 2, 6, -1, -1, 6]);
  expect(editedClass(edits, 3, 9, 9, 5)).toBe(3);
  expect(editedClass([region("crop")], 3, 9, 9, 5)).toBe(-1);
});

const header = { centre: [8, 8, 8], half: 8 } as unknown as CloudHeader;
const node = (level: number, x: number, points = 100): Omit<CloudNode, "children" | "centre" | "half"> => ({ level, position: [x, 0, 0], at: 0, bytes: 1, points });

test("a node without its parent is left out, and cubes halve", () => {
  const nodes = tree(header, [node(2, 3), node(1, 1), node(0, 0), node(2, 0)]);
  expect(nodes.map((one) => one.level)).toEqual([0, 1, 2]);
  expect(nodes[2]).toMatchObject({ half: 2, centre: [14, 2, 2] });
  expect(nodes[1]?.children).toEqual([2]);
});

test("what looks largest comes first, within the budget, and not finer than is seen", () => {
  const nodes = tree(header, [node(0, 0), node(1, 0), node(1, 1), node(2, 0)]);
  const pixels = (one: CloudNode): number => (one.level === 1 && one.position[0] === 1 ? 900 : 1000 / 2 ** one.level);
  expect(wantedNodes(nodes, pixels, 1e6)).toEqual([0, 2, 1, 3]);
  expect(wantedNodes(nodes, pixels, 250)).toEqual([0, 2]);
  expect(wantedNodes(nodes, pixels, 1e6, 5)).toEqual([0, 2, 1]);
  expect(wantedNodes(nodes, (one) => (one.position[0] === 1 ? 0 : pixels(one)), 1e6)).toEqual([0, 1, 3]);
});

test("what was not used for longest makes room, but not what is seen", () => {
  const used = new LeastRecentlyUsed();
  for (const index of [1, 2, 3, 1]) used.use(index, 10);
  expect(used.points).toBe(30);
  expect(used.evicted(15, new Set([3]))).toEqual([2, 1]);
  expect(used.points).toBe(10);
});

test("pictures of cameras are as fine as they are seen, and as many as memory holds", () => {
  const image = (id: number): ImageInfo => ({ id, width: 6000, height: 4000, levels: 6 }) as ImageInfo;
  expect(levelSize(image(0), 0)).toEqual([188, 125]);
  const all = Array.from({ length: 1000 }, (_, id) => ({ image: image(id), size: 170 + id }));
  const many = wantedPictures(all, 100e6);
  expect(many.length).toBe(Math.floor(100e6 / Math.ceil((188 * 125 * 16) / 3)));
  expect(many[0]).toMatchObject({ id: 999, level: 0 });
  expect(many.reduce((sum, one) => sum + one.bytes, 0)).toBeLessThanOrEqual(100e6);
  const few = wantedPictures([700, 150, 300, 180, 5000].map((size, id) => ({ image: image(id), size })), 100e6);
  expect(few.map((one) => [one.id, one.level])).toEqual([[4, 2], [0, 2], [2, 1], [3, 0]]);
  const tight = wantedPictures([700, 300, 180].map((size, id) => ({ image: image(id), size })), 0.8e6);
  expect(tight.map((one) => [one.id, one.level])).toEqual([[0, 1], [1, 0], [2, 0]]);
});

test("standard deviations are kept to a fortieth", () => {
  for (let sigma = 2e-4; sigma < 5; sigma *= 1.37) expect(Math.abs(sigmaOfCode(sigmaCode(sigma)) / sigma - 1)).toBeLessThan(0.025);
  expect([sigmaCode(0), sigmaCode(1e9), sigmaCode(1e-9)]).toEqual([0, 255, 1]);
});

test("a place that is zoomed about, or held, stays where it is", () => {
  const view = new Viewpoint();
  for (const isParallel of [false, true]) {
    view.isParallel = isParallel;
    view.look(0.7, 1.1);
    const place = view.onPlane(view.ray(0.4, -0.3, 1.5));
    view.zoom(0.5, place);
    const { origin, direction } = view.ray(0.4, -0.3, 1.5);
    const off = cross(sum(place, origin, -1), direction);
    expect(Math.hypot(...off)).toBeLessThan(1e-9 * 100);
  }
});

test("rays reach the rim of the view in the field of view that there is, until it is levelled", () => {
  const view = new Viewpoint();
  const half = (x: number, y: number): number => Math.acos(dot(view.ray(x, y, 1).direction, view.axes.forward));
  const usual = half(0, 1);
  view.lookAlong([0.1, -0.2, -1], [0.9, 0.3, 0]);
  view.fov = 1.2;
  for (const [x, y] of [[0, 1], [0, -1], [1, 0]] as const) expect(half(x, y)).toBeCloseTo(0.6, 12);
  expect(view.halfHeight).toBeCloseTo(view.distance * Math.tan(0.6), 12);
  view.level();
  expect(half(0, 1)).toBeCloseTo(usual, 12);
});

test("all of a box is in the view, and touches its rim", () => {
  const view = new Viewpoint();
  const [low, high]: [Triple, Triple] = [[-60, 10, 3], [90, 70, 30]];
  for (const isParallel of [false, true])
    for (const [heading, tilt, aspect] of [[0, 0.9, 1.3], [0.7, 0, 0.6], [-2, 1.5, 2]] as const) {
      view.isParallel = isParallel;
      view.look(heading, tilt);
      view.fit(low, high, aspect);
      const { right, up, forward } = view.axes;
      let farthest = 0;
      for (const e of [low[0], high[0]])
        for (const n of [low[1], high[1]])
          for (const h of [low[2], high[2]]) {
            const by = sum([e, n, h], view.target, -1);
            const half = view.halfHeight * (isParallel ? 1 : (view.distance + dot(by, forward)) / view.distance);
            farthest = Math.max(farthest, Math.abs(dot(by, up)) / half, Math.abs(dot(by, right)) / half / aspect);
          }
      expect(farthest).toBeCloseTo(0.95, 9);
    }
});

test("axes are square to each other, also with a roll", () => {
  const view = new Viewpoint();
  view.lookAlong([0.1, -0.2, -1], [0.9, 0.3, 0]);
  const { forward, up, right } = view.axes;
  for (const [a, b] of [[forward, up], [up, right], [right, forward]] as const) expect(Math.abs(dot(a, b))).toBeLessThan(1e-12);
  expect(Math.hypot(...sum(cross(forward, up), right, -1))).toBeLessThan(1e-12);
  expect(dot(up, [0.9, 0.3, 0])).toBeGreaterThan(0.9);
});

test("a region becomes the command of the journal", () => {
  const draft = new RegionDraft();
  drawing.chosen = "F1";
  draft.begin();
  expect(drawing.chosen).toBeUndefined(); // Delete is not about a feature
  for (const [e, n] of square) draft.add([e, n, 0]);
  [draft.low, draft.class] = ["−2,5", 6];
  expect(draft.isReady).toBe(true);
  expect(draft.command("classify")).toEqual(["classify", "6", "-2.5", "-", "0.000", "0.000", "4.000", "0.000", "4.000", "4.000", "0.000", "4.000"]);
  draft.high = "-3";
  expect(draft.isReady).toBe(false);
});
