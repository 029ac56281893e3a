// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from "vitest";

import type { StereoGeometry, StereoMark } from "../../lib/stereo_types";
import { Geometry, pixelAt } from "./geometry";

// Two cameras 80 m above the origin that look down, 20 m apart; a map that is turned and bent a little.
const [s, c] = [Math.sin(0.1), Math.cos(0.1)];
const of: StereoGeometry = {
  focal_px: 1000,
  base_m: 20,
  left_from_world: { rotation: [1, 0, 0, 0, -1, 0, 0, 0, -1], translation: [10, 0, 80] },
  left: { cx: 500, cy: 400 },
  right: { cx: 480, cy: 400 },
  map: { origin: [0, 0, 0], scale_m: 100, coefficients: [[500000, 100 * c, 100 * s, 0, 0.01, 0, 0, 0, 0, 0], [5000000, -100 * s, 100 * c, 0, 0, 0, 0, 0.02, 0, 0], [300, 0, 0, 100, 0.003, 0, 0, 0.003, 0, 0]] },
};
const geometry = new Geometry(of);

describe("the geometry of a pair", () => {
  it("has the mark of a point where two cameras see it", () => {
    // The point (5, 3, 10) of the world is 15 m right of the left camera, 3 m up, 70 m away.
    const mark = geometry.markAt([5, 3, 10]);
    expect(mark?.[0]).toBeCloseTo(500 + (1000 * 15) / 70, 9);
    expect(mark?.[1]).toBeCloseTo(400 - (1000 * 3) / 70, 9);
    const right = 480 + (1000 * -5) / 70;
    expect((mark?.[0] ?? 0) - (mark?.[2] ?? 0)).toBeCloseTo(right, 9);
    const back = geometry.positionOf(mark as StereoMark);
    [5, 3, 10].forEach((value, k) => expect(back?.[k]).toBeCloseTo(value, 9));
  });

  it("goes to the map and back", () => {
    for (const world of [[5, 3, 10], [-40, 60, -5]] as [number, number, number][]) {
      const back = geometry.worldOf(geometry.mapOf(world));
      world.forEach((value, k) => expect(back[k]).toBeCloseTo(value, 6));
    }
  });

  it("keeps the height of the map when the mark moves in plan", () => {
    const mark = geometry.markAtHeight(530, 420, 312, geometry.parallaxAt(80));
    const position = geometry.positionOf(mark as StereoMark);
    expect(geometry.mapOf(position as [number, number, number])[2]).toBeCloseTo(312, 6);
    expect(mark?.[0]).toBe(530);
  });

  it("has no position where the rays do not meet", () => {
    expect(geometry.positionOf([1, 1, 20])).toBeUndefined();
    expect(geometry.positionOf([1, 1, 10])).toBeUndefined();
    expect(geometry.markAt([0, 0, 90])).toBeUndefined();
  });

  it("interpolates pixels and says where there are none", () => {
    const lattice = { step_px: 10, columns: 3, rows: 2, error_px: 0, nodes: [0, 0, 10, 1, null, null, 0, 10, 10, 11, 20, 12] };
    expect(pixelAt(lattice, 5, 5)).toEqual([5, 5.5]);
    expect(pixelAt(lattice, 15, 5)[0]).toBeNaN();
    expect(pixelAt(lattice, -1, 5)[0]).toBeNaN();
  });
});
