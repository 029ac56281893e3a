// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from "vitest";

import { freeName, Outline } from "./outline.svelte";
import type { Vector2 } from "./types";

describe("an outline", () => {
  const ring: Vector2[] = [[0, 0], [10, 0], [10, 10], [5, 2], [0, 10]];

  it("is finished with three points, and says them in words", () => {
    const outline = new Outline();
    for (const point of ring.slice(0, 3)) outline.add(point);
    expect(outline.canFinish).toBe(true);
    outline.back();
    expect(outline.canFinish).toBe(false);
    expect(outline.words(1)).toEqual(["0.0", "0.0", "10.0", "0.0"]);
  });

  it("gets a name that is free", () => {
    expect(freeName("M", ["M1", "M3"])).toBe("M2");
    expect(freeName("M", [])).toBe("M1");
  });
});
