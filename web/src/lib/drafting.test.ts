// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import * as api from "./api";
import { drafting, squared } from "./drafting.svelte";
import type { AskedVertex, Vertex } from "./drawing_types";
import { nearestVertex } from "./snapping";

it("puts a vertex square to the side before it", () => {
  expect(squared([0, 0, 5], [10, 0, 5], [12, 7, 5])).toEqual([10, 7]);
  const [x, y] = squared([0, 0, 0], [3, 4, 0], [1, 9, 0]);
  expect(3 * (x - 3) + 4 * (y - 4)).toBeCloseTo(0, 12);
  expect(squared([1, 1, 0], [1, 1, 0], [4, 5, 0])).toEqual([4, 5]);
});

it("finds the nearest vertex within reach", () => {
  const features = [
    { id: "F1", vertices: [{ at: [0, 0] }, { at: [10, 0] }] },
    { id: "F2", vertices: [{ at: [9, 1] }, { at: null }] },
  ];
  const place = (vertex: { at: number[] | null }): [number, number] | null => vertex.at as [number, number] | null;
  expect(nearestVertex(features, place, [9.4, 0.7], 3)).toEqual({ feature: "F2", vertex: 0 });
  expect(nearestVertex(features, place, [5, 5], 3)).toBeUndefined();
});

describe("answers that come late", () => {
  const at = (e: number): AskedVertex => ({ at: [e, 0, 0] });
  const vertexOf = (asked: AskedVertex): Vertex => ({
    position: "at" in asked ? asked.at : "marks" in asked ? [asked.marks.length, 0, 0] : [0, 0, 0], covariance_m2: null, sigma_m: null, source: "typed", marks: [],
  });
  const east = (): number[] => drafting.vertices.map((one) => one.position[0]);
  let waiting: (() => void)[] = [];
  let drawn: string[][] = [];
  /** Lets the server answer, one request after the other. */
  const answer = async (count = 1): Promise<void> => {
    for (let k = 0; k < count; ++k) {
      await vi.waitFor(() => expect(waiting.length).toBeGreaterThan(0));
      waiting.shift()?.();
      await new Promise((resolve) => setTimeout(resolve));
    }
  };

  beforeEach(() => {
    [waiting, drawn] = [[], []];
    vi.spyOn(api, "vertices").mockImplementation(async (_project, asked) => {
      await new Promise<void>((resolve) => waiting.push(resolve));
      return { vertices: asked.map(vertexOf) };
    });
    vi.spyOn(api, "edit").mockImplementation(async (_project, command) => ({ number: drawn.push(command) }));
    vi.spyOn(api, "drawing").mockResolvedValue({ layers: [], codes: [], features: [] });
    drafting.of(`another ${Math.random()}`);
    [drafting.tool, drafting.kind, drafting.square, drafting.code] = ["draw", "line", false, ""];
  });
  afterEach(() => {
    vi.restoreAllMocks();
  });

  it("are dropped when the figure is cancelled, or another project is looked at", async () => {
    for (const leave of [() => drafting.cancel(), () => drafting.of("elsewhere")]) {
      const added = [drafting.add(at(1)), drafting.add(at(2))];
      await vi.waitFor(() => expect(waiting.length).toBe(1));
      leave();
      await answer();
      expect(await Promise.all(added)).toEqual([false, false]);
      expect(east()).toEqual([]);
      expect(waiting).toEqual([]);
    }
  });

  it("are taken back before what is there", async () => {
    const first = drafting.add(at(1));
    await answer();
    await first;
    const second = drafting.add(at(2));
    drafting.back();
    const third = drafting.add(at(3));
    await answer();
    expect(await Promise.all([second, third])).toEqual([false, true]);
    expect(east()).toEqual([1, 3]);
    drafting.back();
    expect(east()).toEqual([1]);
  });

  it("are marked again in the order of the clicks", async () => {
    const mark = (image: number, again: boolean): Promise<boolean> => drafting.mark({ image, pixel: [0, 0] }, again);
    const marked = [mark(1, false), mark(2, true), mark(3, true)];
    await answer(3);
    expect(await Promise.all(marked)).toEqual([true, true, true]);
    expect(east()).toEqual([3]); // one vertex with three marks
  });

  const three = async (): Promise<void> => {
    const added = [1, 2, 3].map((e) => drafting.add(at(e)));
    await answer(3);
    await Promise.all(added);
  };

  it("close a figure that is drawn and has three vertices, and leave it as it was where they are refused", async () => {
    await three();
    drafting.tool = "measure";
    expect(await drafting.close()).toBeNull();
    expect(east()).toEqual([1, 2, 3]);
    drafting.tool = "draw";
    vi.mocked(api.edit).mockRejectedValueOnce(new Error("no"));
    await drafting.close();
    expect([east(), drafting.error]).toEqual([[1, 2, 3], "no"]);
    await drafting.close();
    expect(east()).toEqual([]);
    expect(drawn[0]?.slice(4).filter((word) => word === "typed").length).toBe(4); // back to the first
    const added = drafting.add(at(1));
    await answer();
    await added;
    expect(await drafting.close()).toBeNull();
    expect([east(), drawn.length]).toEqual([[1], 1]);
  });
});
