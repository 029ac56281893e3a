// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";

import { images, truePixel } from "./mock_world.mjs";
import { quiet } from "./quiet.mjs";

/** x, y under the pointer, as the page shows them [px]. */
export async function cursorOf(page) {
  const text = await page.locator(".readout .where").innerText();
  return [...text.matchAll(/\d+\.\d+/g)].map((found) => Number(found[0]));
}

const stage = (page) => page.getByRole("application");
const scaleOf = async (page) => Number((await page.locator(".readout .number").innerText()).replace(/[^\d]/g, "")) / 100;

/** The colour of the photograph at a place of the screen. */
const colourAt = (page, x, y) =>
  page.evaluate(([x, y]) => {
    const canvas = document.querySelector(".photograph canvas, canvas.photograph");
    const box = canvas.getBoundingClientRect();
    const at = [((x - box.left) * canvas.width) / box.width, ((y - box.top) * canvas.height) / box.height].map(Math.floor);
    return [...canvas.getContext("2d").getImageData(...at, 1, 1).data];
  }, [x, y]);

export const photographTests = {
  async "photographs are listed, filtered, and gone through by keys"({ page, open }) {
    await open("photographs");
    await page.getByText("16 of 16 photographs").waitFor();
    await page.getByLabel("Name").fill("001");
    await page.getByText("8 of 16 photographs").waitFor();
    await page.getByLabel("Which photographs").selectOption("not oriented");
    await page.getByText("1 of 16 photographs").waitFor();
    await page.getByLabel("Which photographs").selectOption("all");
    await page.getByLabel("Name").fill("");
    await page.getByRole("link", { name: "DJI_0003" }).click();
    await page.getByRole("application", { name: "Photograph DJI_0003.jpg" }).focus();
    await page.keyboard.press("n");
    await page.getByRole("application", { name: "Photograph DJI_0004.jpg" }).waitFor();
    await page.keyboard.press("p");
    await page.keyboard.press("p");
    await page.getByRole("application", { name: "Photograph DJI_0002.jpg" }).waitFor();
  },

  // The middle of a chequerboard, whose pixel is known, is where the page says it is: its quarters lie about it.
  async "pixels are where they are, in native size and beyond"({ page, open }) {
    await open("photographs/4");
    const target = stage(page);
    await target.locator("canvas").first().waitFor({ state: "attached" });
    const box = await target.boundingBox();
    const middle = [box.x + box.width / 2, box.y + box.height / 2].map(Math.round);
    const [x, y] = truePixel("P4", images[3]);
    await page.mouse.move(...middle);
    await page.keyboard.press("1");
    await page.waitForFunction(() => document.querySelector(".readout .number").textContent.startsWith("100"));
    for (let i = 0; i < 6; ++i) {
      const [cx, cy] = await cursorOf(page);
      const [dx, dy] = [x - cx, y - cy];
      if (Math.hypot(dx, dy) < 1) break;
      await page.mouse.down();
      const step = [-dx, -dy].map((one) => Math.max(-250, Math.min(250, one)));
      await page.mouse.move(middle[0] + step[0], middle[1] + step[1], { steps: 4 });
      await page.waitForTimeout(150); // no throw
      await page.mouse.up();
      await page.mouse.move(...middle);
      await page.waitForTimeout(50);
    }
    const aimed = await cursorOf(page);
    assert.ok(Math.hypot(aimed[0] - x, aimed[1] - y) < 2, `${aimed}`);
    await page.keyboard.press("8");
    await quiet(page);
    assert.equal(await scaleOf(page), 8);
    await page.mouse.move(middle[0] + 1, middle[1]);
    await page.mouse.move(...middle);
    const [cx, cy] = await cursorOf(page);
    assert.ok(Math.hypot(cx - aimed[0], cy - aimed[1]) < 0.02, `zoomed about the pointer: ${cx} ${cy}, not ${aimed}`);
    for (const [sx, sy, light] of [[1, 1, true], [-1, -1, true], [1, -1, false], [-1, 1, false]]) {
      const [r] = await colourAt(page, middle[0] + (x + sx * 4 - cx) * 8, middle[1] + (y + sy * 4 - cy) * 8);
      assert.equal(r > 128, light, `quarter ${sx} ${sy} is ${r}`);
    }
    const before = await cursorOf(page);
    await page.keyboard.press("d");
    await page.mouse.move(middle[0] + 1, middle[1]);
    const after = await cursorOf(page);
    assert.ok(after[0] > before[0] + 5 && Math.abs(after[1] - before[1]) < 0.5, "D moves to the right");
    await page.keyboard.press("0");
    await page.mouse.move(middle[0] + 2, middle[1]);
    assert.ok((await scaleOf(page)) < 1);
  },

  async "grey values are changed, and stay so for the next photograph"({ page, open, shot }) {
    await open("photographs/4");
    await page.getByRole("button", { name: "Tone" }).click();
    await page.getByLabel("Equalise").check();
    await page.getByLabel("Gamma").fill("2");
    const filter = () => page.evaluate(() => document.querySelector(".photograph").style.filter);
    await page.waitForFunction(() => document.querySelector(".photograph").style.filter.includes("url("));
    const table = await page.locator("feFuncG").getAttribute("tableValues");
    const values = table.split(" ").map(Number);
    assert.ok(values.every((one, at) => at === 0 || one >= values[at - 1]) && values.at(-1) > 0.99, table);
    await shot("tone");
    await page.reload();
    await page.waitForFunction(() => document.querySelector(".photograph")?.style.filter.includes("url("));
    await page.getByRole("button", { name: "Tone" }).click();
    await page.getByRole("button", { name: "As it is" }).click();
    await page.waitForFunction(() => document.querySelector(".photograph").style.filter === "");
    assert.equal(await filter(), "");
  },

  async "marks and residuals are shown and their enlargement is told"({ page, open, shot, judge, world }) {
    for (const name of ["P3", "P4", "P5"]) world.edit(["mark", name, "DJI_0004.jpg", ...truePixel(name, images[3]).map((one) => String(one + 0.3)), "0.3"]);
    await open("photographs/4");
    await page.locator(".readout").getByText("3 marks").waitFor();
    await page.getByRole("button", { name: "Show", exact: true }).click();
    await page.getByLabel("Residuals of tie points").check();
    await page.getByText("400 tie points, vectors enlarged 50 ×").waitFor();
    await page.getByLabel("Vectors").selectOption("100 ×");
    await page.getByText("400 tie points, vectors enlarged 100 ×").waitFor();
    await page.getByLabel("Loupe").selectOption("× 8");
    const box = await stage(page).boundingBox();
    for (const theme of ["light", "dark"]) {
      await page.getByLabel("Theme").selectOption(theme);
      for (const [width, height] of [[1280, 800], [1920, 1080]]) {
        await page.setViewportSize({ width, height });
        await page.mouse.move(box.x + 300, box.y + 250);
        await quiet(page);
        await shot(`photographs-${theme}-${width}`);
      }
      await judge(`photographs, ${theme}`);
    }
  },
};
