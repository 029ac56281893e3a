// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import type { Place } from "../../lib/types";
import { offOf, pointOfTag } from "./found";

test("a tag is the point called by its number, else the only one whose name ends in it", () => {
  expect(pointOfTag(["12", "T-012", "A3_12"], 12)).toBe("12");
  expect(pointOfTag(["T-012", "112", "12a"], 12)).toBe("T-012");
  expect(pointOfTag(["T-012", "A3_12"], 12)).toBeUndefined();
  expect(pointOfTag(["tag0", "tag"], 0)).toBe("tag0");
  expect(pointOfTag([], 3)).toBeUndefined();
});

test("a target far from its predicted position is doubted, where that is known", () => {
  const place: Place = { image: 1, file: "1.jpg", pixel: [100, 50], ellipse: { major_px: 1, minor_px: 0.5, angle_deg: 0 }, marked: false, hidden: false, sigma_after_m: null };
  expect(offOf([103, 50], place)).toEqual({ off_px: 3, isFar: false });
  expect(offOf([100, 54.5], place)).toEqual({ off_px: 4.5, isFar: true });
  expect(offOf([900, 0], { ...place, ellipse: null })).toEqual({ off_px: undefined, isFar: false });
});
