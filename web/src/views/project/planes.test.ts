// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import { planesOf } from "./planes";

test("planes are those that have something to show, by their names", () => {
  const files = ["frames/frames.txt", "frames/plane10/elevation.pdf", "frames/plane2/dsm.tif", "frames/plane2/ortho.tif", "frames/plane2/elevation.pdf", "frames/plane3/dsm.tif", "ortho.tif"].map((path, i) => ({ path: `products/${path}`, bytes: i }));
  expect(planesOf(files).map((one) => [one.name, one.ortho?.path, one.view?.bytes])).toEqual([
    ["plane2", "products/frames/plane2/ortho.tif", 4],
    ["plane10", undefined, 1],
  ]);
});
