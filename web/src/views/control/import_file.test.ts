// SPDX-License-Identifier: Apache-2.0
import { expect, test } from "vitest";

import type { ImageInfo } from "../../lib/types";
import { imageNamed, textOf } from "./import_file.svelte";

const images = ["a/IMG_1.JPG", "b/IMG_1.JPG", "b/IMG_2.tif"].map((file, id) => ({ id, file }) as ImageInfo);

test("a photograph is found by path, and by name where that names one only", () => {
  expect(imageNamed(images, "b\\IMG_1.JPG")?.id).toBe(1);
  expect(imageNamed(images, "img_2.TIF")?.id).toBe(2);
  expect(imageNamed(images, "img_2")?.id).toBe(2);
  expect([imageNamed(images, "IMG_1.JPG"), imageNamed(images, "img_1"), imageNamed(images, "")]).toEqual([undefined, undefined, undefined]);
});

test("texts are read in the encodings that surveyors' programs write", () => {
  expect(textOf(new TextEncoder().encode("Höhe"))).toBe("Höhe");
  expect(textOf(Uint8Array.from([0x48, 0xf6, 0x68, 0x65]))).toBe("Höhe");
  expect(textOf(Uint8Array.from([0xff, 0xfe, 0x48, 0, 0xf6, 0]))).toBe("Hö");
});
