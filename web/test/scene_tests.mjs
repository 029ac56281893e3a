// SPDX-License-Identifier: Apache-2.0
// The cloud in space, in a browser without a GPU, against the files of the project.
import assert from "node:assert/strict";
import { join } from "node:path";

import { readValue } from "./height.mjs";
import { drawn } from "./quiet.mjs";

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
  await drawn(page); // what was asked for has begun
  await readout(page).locator(".state").getByText(/^\s*[1-9][\d,]* of [\d,]+ points\s*$/).waitFor({ timeout: 30_000 });
  await page.locator('.scene [role="application"]:not([aria-busy="true"])').waitFor();
  await drawn(page);
};

/** Where control points lie on the map. */
const controlOf = async (page, project) =>
  (await page.evaluate(async (path) => (await fetch(path)).json(), `/api/projects/${project.id}/control`)).points
    .filter((one) => one.role === "control").map((one) => one.adjusted ?? one.position);

/** Middles of the marks of control points on the screen, each a ring of its colour; shading by depth changes that. */
async function marksOnScreen(page) {
  const bytes = await scene(page).screenshot();
  const box = await scene(page).boundingBox();
  const middles = await page.evaluate(async (base64) => {
    const bytes = Uint8Array.from(atob(base64), (one) => one.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const rings = [];
    for (let i = 0; i < data.length; i += 4) {
      if (Math.max(Math.abs(data[i] - 194), Math.abs(data[i + 1] - 24), Math.abs(data[i + 2] - 91)) > 24) continue;
      const [x, y] = [(i / 4) % bitmap.width, Math.floor(i / 4 / bitmap.width)];
      const ring = rings.find((one) => Math.hypot(one[0][0] - x, one[0][1] - y) < 20);
      if (ring) ring.push([x, y]);
      else rings.push([[x, y]]);
    }
    const middle = (ring, axis) => (Math.min(...ring.map((one) => one[axis])) + Math.max(...ring.map((one) => one[axis])) + 1) / 2;
    return rings.filter((ring) => ring.length > 20).map((ring) => [middle(ring, 0), middle(ring, 1)]);
  }, bytes.toString("base64"));
  return middles.map(([x, y]) => [box.x + x, box.y + y]);
}

/** E, N, H and the standard deviation of the point at a place of the screen; nothing where there is none. */
async function pickAt(page, x, y) {
  await page.mouse.move(x + 40, y);
  await page.waitForTimeout(150);
  const before = await readout(page).innerText();
  await page.mouse.move(x, y);
  for (let i = 0; i < 40 && (await readout(page).innerText()) === before; ++i) await page.waitForTimeout(25);
  const picked = [...(await readout(page).innerText()).replaceAll("±", "").matchAll(/\d+\.\d+/g)].slice(0, 4).map(Number);
  return picked.length === 4 ? picked : undefined;
}

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
  async "what is picked lies on the surface"({ page, folder, project }) {
    await page.getByLabel("Coloured by").selectOption("colour");
    await page.getByRole("button", { name: "Top" }).click();
    await page.getByRole("button", { name: "Parallel" }).click();
    await settled(page);
    const box = await scene(page).boundingBox();
    const misses = [];
    const picks = [];
    for (const [x, y] of [[0.5, 0.5], [0.45, 0.55], [0.55, 0.45], [0.42, 0.42], [0.58, 0.58]]) {
      const at = [box.x + x * box.width, box.y + y * box.height];
      const [e, n, h, sigma] = await pickAt(page, ...at);
      assert.ok(sigma > 0 && sigma < 1, `sigma ${sigma}`);
      misses.push(Math.abs((await readValue(join(folder, "products/dsm.tif"), e, n)) - h));
      picks.push([at, [e, n]]);
    }
    // Marks of control points say where the map is on the screen: seen from above E grows to the right as N grows upwards.
    await page.getByLabel("Control and check points", { exact: true }).check();
    await settled(page);
    const control = await controlOf(page, project);
    const marks = await marksOnScreen(page);
    assert.equal(marks.length, control.length);
    const ends = [control.reduce((a, b) => (a[0] - a[1] < b[0] - b[1] ? a : b)), control.reduce((a, b) => (a[0] - a[1] > b[0] - b[1] ? a : b))];
    const shown = [marks.reduce((a, b) => (a[0] + a[1] < b[0] + b[1] ? a : b)), marks.reduce((a, b) => (a[0] + a[1] > b[0] + b[1] ? a : b))];
    const perPixel = Math.hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]) / Math.hypot(shown[1][0] - shown[0][0], shown[1][1] - shown[0][1]);
    const mapAt = ([x, y]) => [ends[0][0] + perPixel * (x - shown[0][0]), ends[0][1] - perPixel * (y - shown[0][1])];
    // A mark is found to a pixel, and of the points about a pixel, a cell of the surface from each other, the higher one may be taken.
    const reach = 2 * perPixel + 2 * 0.16;
    const off = Math.max(...picks.map(([at, place]) => Math.hypot(...mapAt(at).map((value, axis) => value - place[axis]))));
    assert.ok(off < reach, `${off} m from where the pixel is, of ${reach}`);
    await page.getByLabel("Control and check points", { exact: true }).uncheck();
    // A cell of 0.16 m has the height of several points; beside a wall it is that of the roof.
    assert.ok(misses.filter((miss) => miss < 0.3).length >= 3, `${misses} m off the surface`);
  },

  async "a distance between points comes with its standard deviation"({ page }) {
    await page.getByRole("button", { name: "Measure" }).click();
    const box = await scene(page).boundingBox();
    const picks = [];
    for (const x of [0.46, 0.54]) {
      const at = [box.x + x * box.width, box.y + 0.5 * box.height];
      picks.push(await pickAt(page, ...at));
      await page.mouse.click(...at);
      await page.getByRole("status").getByText(x === 0.46 ? /^1 / : /^2 /).waitFor();
    }
    const text = await page.locator("aside dl dt").filter({ hasText: /^Distance$/ }).locator("+ dd").innerText();
    const [, distance, sigma] = /^(\d+\.\d+) ± (0\.\d+) m$/.exec(text) ?? assert.fail(text);
    const [a, b] = picks;
    const apart = Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
    // What is measured lies where the pixels are, on the plane of the points about those that were picked: within the reach of a pick from these.
    assert.ok(Math.abs(Number(distance) - apart) < 3 * Number(sigma), `${text}: ${apart}`);
    assert.ok(Number(sigma) > Math.min(a[3], b[3]) && Number(sigma) < 1, `${text}: ${a[3]} and ${b[3]}`);
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
    // Also in the field of view of a photograph what is picked at a mark is where the control point lies.
    await page.getByLabel("Control and check points", { exact: true }).check();
    await page.getByLabel("Shading by depth").uncheck();
    await settled(page);
    const control = await controlOf(page, project);
    const marks = await marksOnScreen(page);
    assert.ok(marks.length > 0, "a control point is seen");
    const offs = [];
    for (const mark of marks) {
      const picked = await pickAt(page, ...mark);
      if (picked) offs.push(Math.min(...control.map((place) => Math.hypot(...place.map((value, axis) => value - picked[axis])))));
    }
    // A mark is found to a pixel of 0.2 m, and points lie a cell of 0.16 m from each other.
    assert.ok(offs.length > 0 && offs.every((off) => off < 0.5), `${offs} m off`);
    await page.getByRole("button", { name: "Open in Photographs" }).click();
    await page.waitForURL(new RegExp(`#/${project.id}/photographs/\\d+$`));
  },
};
