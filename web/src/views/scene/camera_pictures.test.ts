// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, expect, test, vi } from "vitest";

import type { ImageInfo } from "../../lib/types";
import { CameraPictures, levelSize } from "./camera_pictures";
import type { Pyramid } from "./pyramids";

interface Asked {
  id: number;
  level: number;
  come(bitmap?: ImageBitmap): Promise<void>;
  fail(): Promise<void>;
}

const settle = async (): Promise<void> => {
  for (let i = 0; i < 4; ++i) await Promise.resolve();
};
const bitmap = (): ImageBitmap => ({ close: vi.fn() }) as unknown as ImageBitmap;
const pyramid = (id: number, east = 0): Pyramid => ({
  image: { id, width: 6000, height: 4000, levels: 6 } as ImageInfo,
  apex: [east, 0, 5],
  corners: [[east, 1, 0], [east + 1, 1, 0], [east + 1, 0, 0], [east, 0, 0]],
});

let asked: Asked[] = [];
let changes = 0;
function pictures(): CameraPictures {
  return new CameraPictures("p", () => ++changes, (_, image, level) =>
    new Promise((resolve, reject) => {
      asked.push({
        id: image.id, level,
        come: (one) => (resolve(one), settle()),
        fail: () => (reject(new Error("closed")), settle()),
      });
    }),
  );
}

beforeEach(() => {
  [asked, changes] = [[], 0];
  vi.useFakeTimers();
});
afterEach(() => void vi.useRealTimers());

test("a picture that cannot be read stops no other, is asked for again later, and at last no more", async () => {
  const all = pictures();
  const cameras = Array.from({ length: 9 }, (_, id) => pyramid(id));
  const frame = (): void => all.update(cameras, () => 170);
  frame();
  expect(asked.length).toBe(4);
  for (const one of asked.slice(0, 4)) await (one.id % 2 ? one.fail() : one.come());
  frame();
  frame();
  expect(asked.slice(4).map((one) => one.id)).toEqual([4, 5, 6, 7]);
  for (const one of asked.slice(4)) await one.come(bitmap());
  frame();
  await asked[8]?.come(bitmap());
  frame();
  expect(all.group.children.length).toBe(5);
  expect(all.isBusy).toBe(false);
  for (let i = 0; i < 200; ++i) {
    await vi.advanceTimersByTimeAsync(1000);
    frame();
    for (const one of asked.slice(-4)) await one.come();
  }
  for (const id of [0, 1, 2, 3]) expect(asked.filter((one) => one.id === id).length).toBe(6);
});

test("pictures of the images before are not shown of those after them, and failures are forgotten", async () => {
  const all = pictures();
  const frame = (east: number): void => all.update([pyramid(0, east), pyramid(1, east)], () => 170);
  frame(0);
  await asked[1]?.come(); // failed
  all.clear();
  frame(100);
  expect(asked.map((one) => one.id)).toEqual([0, 1, 0, 1]);
  const old = bitmap();
  await asked[0]?.come(old);
  expect(old.close).toHaveBeenCalled();
  frame(100);
  expect(all.group.children.length).toBe(0);
  await asked[2]?.come(bitmap());
  frame(100);
  const mesh = all.group.children[0] as unknown as { geometry: { getAttribute(name: string): { getX(i: number): number } } };
  expect(mesh.geometry.getAttribute("position").getX(0)).toBe(100);
});

test("pictures that are not seen make room, those that are seen stay, and bitmaps are given back", async () => {
  const all = pictures();
  const finest = Math.ceil((16 / 3) * levelSize(pyramid(0).image, 2).reduce((a, b) => a * b));
  const count = Math.floor(96e6 / finest);
  const bitmaps: ReturnType<typeof bitmap>[] = [];
  const look = async (from: number, to: number): Promise<void> => {
    const cameras = Array.from({ length: to - from }, (_, i) => pyramid(from + i));
    for (let i = 0; i < 3 * (to - from); ++i) {
      all.update(cameras, () => 5000);
      for (const one of asked.splice(0)) {
        bitmaps.push(bitmap());
        await one.come(bitmaps.at(-1));
      }
    }
  };
  await look(0, count);
  expect(all.group.children.length).toBe(count);
  await look(count, count + 2);
  expect(all.group.children.filter((one) => one.visible).length).toBe(2);
  expect(all.group.children.length).toBe(count);
  expect(bitmaps.filter((one) => vi.mocked(one.close).mock.calls.length > 0).length).toBe(2);
  all.clear();
  expect(all.group.children.length).toBe(0);
  expect(bitmaps.every((one) => vi.mocked(one.close).mock.calls.length > 0)).toBe(true);
});
