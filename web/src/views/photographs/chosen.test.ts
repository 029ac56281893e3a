// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import type { ImageInfo } from "../../lib/types";
import { listed, neighbour } from "./chosen";

const image = (id: number, file: string, oriented: boolean, marks: number): ImageInfo => ({ id, file, oriented, marks }) as ImageInfo;
const images = [image(1, "IMG_10.jpg", true, 0), image(2, "IMG_2.jpg", true, 3), image(3, "other/img_1.jpg", false, 0)];

test("photographs are listed by name with numbers as numbers", () => {
  expect(listed(images, "", "all").map((one) => one.id)).toEqual([2, 1, 3]);
});

test("name and state both count", () => {
  expect(listed(images, "img_1", "all").map((one) => one.id)).toEqual([1, 3]);
  expect(listed(images, " IMG_1", "not_oriented").map((one) => one.id)).toEqual([3]);
  expect(listed(images, "", "marked").map((one) => one.id)).toEqual([2]);
  expect(listed(images, "none", "all")).toEqual([]);
});

test("behind the last comes the first", () => {
  const order = listed(images, "", "all");
  expect(neighbour(order, 3, 1)?.id).toBe(2);
  expect(neighbour(order, 2, -1)?.id).toBe(3);
  expect(neighbour(order, 99, 1)?.id).toBe(2);
  expect(neighbour([], 1, 1)).toBeUndefined();
});
