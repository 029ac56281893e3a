// SPDX-License-Identifier: Apache-2.0
// The cloud in space, in a browser without a GPU, against the files of the project.
import assert from "node:assert/strict";
import { join } from "node:path";

import { readValue } from "./height.mjs";

const rail = (page, name) => page.getByRole("navigation", { name: "Views" }).getByRole("link", { name, exact: true });
const scene = (page) => page.getByRole("application", { name: "Cloud and scene" });
const readout = (page) => page.locator(".scene .readout");

/** Colours on the screen, by how many pixels of the scene have them (of every third, to 5 bits). */
async function colours(page) {
  const bytes = await scene(page).screenshot();
  return await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (one) => one.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const counts = {};
    for (let i = 0; i < data.length; i += 12) {
      const key = `${data[i] >> 3} ${data[i + 1] >> 3} ${data[i + 2] >> 3}`;
      counts[key] = (counts[key] ?? 0) + 1;
    }
    return counts;
  }, bytes.toString("base64"));
}

/** Pixels near a colour. */
const near = (counts, [red, green, blue], reach = 3) =>
  Object.entries(counts).reduce((sum, [key, count]) => {
    const [r, g, b] = key.split(" ").map(Number);
    return sum + (Math.max(Math.abs(r - (red >> 3)), Math.abs(g - (green >> 3)), Math.abs(b - (blue >> 3))) <= reach ? count : 0);
  }, 0);

/** Until the view has all its points and nothing is on its way. */
const settled = async (page) => {
  await readout(page).locator(".state").getByText(/^\s*[1-9][\d,]* of [\d,]+ points\s*$/).waitFor({ timeout: 30_000 });
  await page.waitForTimeout(400);
};

const building = [217, 72, 59]; // class 6
const ground = [168, 120, 72]; // class 2

export const sceneTests = {
  async "the cloud appears in space, in the colours that are asked for"({ page }) {
    await rail(page, "Scene").click();
    await settled(page);
    assert.ok(Object.keys(await colours(page)).length > 150, "a cloud in its colours");
    await page.getByLabel("Cameras", { exact: true }).uncheck();
    await page.getByLabel("Control and check points", { exact: true }).uncheck();
    await page.getByLabel("Shading by depth").uncheck();
    await page.getByLabel("Coloured by").selectOption("class");
    await page.getByRole("listitem").filter({ hasText: "2 ground" }).waitFor();
    await settled(page);
    const classes = await colours(page);
    assert.ok(near(classes, ground) > 3000, "most of the village is ground");
    await page.getByLabel("Coloured by").selectOption("height");
    await settled(page);
    const heights = await colours(page);
    assert.ok(near(heights, ground) < near(classes, ground) / 20);
    assert.ok(near(heights, [0x44, 0x01, 0x54]) > 100 && near(heights, [0xfd, 0xe7, 0x25]) > 20, "from the lowest to the highest");
  },

  // The surface is computed from this cloud: where it is level it has the height of the points in a cell of it.
  async "what is picked lies on the surface"({ page, folder }) {
    await page.getByLabel("Coloured by").selectOption("colour");
    await page.getByRole("button", { name: "Top" }).click();
    await page.getByRole("button", { name: "Parallel" }).click();
    await settled(page);
    const box = await scene(page).boundingBox();
    const misses = [];
    for (const [x, y] of [[0.5, 0.5], [0.45, 0.55], [0.55, 0.45], [0.42, 0.42], [0.58, 0.58]]) {
      await page.mouse.move(box.x + x * box.width + 3, box.y + y * box.height);
      const before = await readout(page).innerText();
      await page.mouse.move(box.x + x * box.width, box.y + y * box.height);
      for (let i = 0; i < 40 && (await readout(page).innerText()) === before; ++i) await page.waitForTimeout(25);
      const [e, n, h, sigma] = [...(await readout(page).innerText()).replaceAll("±", "").matchAll(/\d+\.\d+/g)].map(Number);
      assert.ok(sigma > 0 && sigma < 1, `sigma ${sigma}`);
      misses.push(Math.abs((await readValue(join(folder, "products/dsm.tif"), e, n)) - h));
    }
    // A cell of 0.16 m has the height of several points; beside a wall it is that of the roof.
    assert.ok(misses.filter((miss) => miss < 0.3).length >= 3, `${misses} m off the surface`);
  },

  async "a distance between points comes with its standard deviation"({ page }) {
    await page.getByRole("button", { name: "Measure" }).click();
    const box = await scene(page).boundingBox();
    for (const x of [0.46, 0.54]) {
      await page.mouse.click(box.x + x * box.width, box.y + 0.5 * box.height);
      await page.getByRole("status").getByText(x === 0.46 ? /^1 / : /^2 /).waitFor();
    }
    await page.getByText(/\d+\.\d+ m? ?± 0\.\d+ m/).first().waitFor();
    await page.keyboard.press("Escape");
    await page.keyboard.press("Escape");
  },

  async "points of a region get a class, are deleted, and come back"({ page, shots }) {
    await page.getByLabel("Coloured by").selectOption("class");
    await settled(page);
    const before = await colours(page);
    const region = async () => {
      await page.getByRole("button", { name: "Choose a region" }).click();
      const box = await scene(page).boundingBox();
      for (const [x, y] of [[0.42, 0.4], [0.58, 0.4], [0.58, 0.6], [0.42, 0.6]]) {
        const count = await page.getByText(/^\d corners$/).innerText();
        await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
        await page.getByText(`${Number(count[0]) + 1} corners`).waitFor();
      }
    };
    await region();
    await page.getByLabel("Class to give").selectOption("6");
    await page.screenshot({ path: join(shots, "scene-region.png") });
    await page.getByRole("button", { name: "Give class" }).click();
    await page.getByText("1 edits of the cloud in force.").waitFor();
    await settled(page);
    const given = await colours(page);
    assert.ok(near(given, building) > near(before, building) + 1000, `${near(before, building)} to ${near(given, building)}`);
    await region();
    await page.getByRole("button", { name: "Delete inside" }).click();
    await page.getByText("2 edits of the cloud in force.").waitFor();
    await settled(page);
    assert.ok(near(await colours(page), building) < near(before, building) + 100);
    await page.screenshot({ path: join(shots, "scene-cut.png") });
    await page.keyboard.press("Control+z");
    await page.getByText("1 edits of the cloud in force.").waitFor();
    await page.keyboard.press("Control+z");
    await page.getByText("edits of the cloud in force").waitFor({ state: "detached" });
    await settled(page);
    const after = await colours(page);
    assert.ok(Math.abs(near(after, building) - near(before, building)) < 20 && Math.abs(near(after, ground) - near(before, ground)) < 200, "as it was");
  },

  async "a camera is looked through, and leads to its photograph"({ page, shots, project }) {
    await page.getByLabel("Coloured by").selectOption("colour");
    await page.getByLabel("Shading by depth").check();
    await page.getByLabel("Cameras", { exact: true }).check();
    await page.getByRole("button", { name: "Parallel" }).click();
    await page.getByRole("button", { name: "Show all" }).click();
    await settled(page);
    const box = await scene(page).boundingBox();
    const through = page.getByRole("button", { name: "Look through it" });
    for (let y = 0.1; y < 0.9 && !(await through.count()); y += 0.08)
      for (let x = 0.2; x < 0.8 && !(await through.count()); x += 0.08) {
        await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
        await page.waitForTimeout(60);
      }
    await through.click();
    await settled(page);
    await page.screenshot({ path: join(shots, "scene-through.png") });
    await page.getByRole("button", { name: "Leave its view" }).waitFor();
    await page.getByRole("button", { name: "Open in Photographs" }).click();
    await page.waitForURL(new RegExp(`#/${project.id}/photographs/\\d+$`));
  },
};
