// SPDX-License-Identifier: Apache-2.0
// Drawing and measuring in a browser, on the small project of page.mjs, whose roofs are known.
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { join } from "node:path";

import { drawn as isDrawn, quiet } from "./quiet.mjs";
import { normals, roofOf } from "./roof.mjs";

const api = (context, page, project) => {
  const base = `${new URL(page.url()).origin}/api/projects/${project.id}`;
  return {
    get: async (what) => await (await context.request.get(`${base}/${what}`)).json(),
    post: async (what, data) => await (await context.request.post(`${base}/${what}`, { data })).json(),
  };
};

/** How many coordinates of the corners lie within two standard deviations of the truth. */
function within(vertices, corners) {
  let count = 0;
  vertices.forEach((vertex, i) => vertex.position.forEach((value, axis) => (count += Number(Math.abs(value - corners[i][axis]) <= 2 * vertex.sigma_m[axis]))));
  return count;
}

/** Where the view lies once its tools have come to rest. */
async function settled(page) {
  for (let last = ""; ; ) {
    const box = await page.getByRole("application").boundingBox();
    if (JSON.stringify(box) === last) return box;
    last = JSON.stringify(box);
    await quiet(page);
  }
}

/** From places of the map to the screen, by what the readout says under the pointer. */
async function onScreen(page) {
  const box = await page.getByRole("application").boundingBox();
  const readout = page.locator(".readout");
  const position = async () => [...(await readout.innerText()).matchAll(/[EN]\s+(\d+\.\d+)/g)].slice(0, 2).map((found) => Number(found[1])); // degrees follow
  const under = async (x, y) => {
    await page.mouse.move(x + 1, y);
    await isDrawn(page);
    await page.mouse.move(x, y);
    let before = [];
    for (let i = 0; i < 100; ++i) {
      await isDrawn(page);
      await page.waitForTimeout(50);
      const now = await position();
      if (now.length === 2 && now.join() === before.join()) return now; // it shows a position, and has come to rest
      before = now;
    }
    throw new Error(`no position under the pointer at ${x}, ${y}: ${await readout.innerText()}`);
  };
  const [x0, y0, x1, y1] = [box.x + 0.2 * box.width, box.y + 0.2 * box.height, box.x + 0.8 * box.width, box.y + 0.8 * box.height];
  const [[e0, n0], [e1, n1]] = [await under(x0, y0), await under(x1, y1)];
  return ([e, n]) => [x0 + ((e - e0) / (e1 - e0)) * (x1 - x0), y0 + ((n - n0) / (n1 - n0)) * (y1 - y0)];
}

async function clickAll(page, places, features) {
  for (const [index, place] of places.entries()) {
    await page.mouse.click(...place);
    await page.getByRole("status").filter({ hasText: `${index + 1} vertices` }).waitFor();
  }
  await page.keyboard.press("Enter");
  await page.getByRole("listbox", { name: `${features} features` }).waitFor();
}

/** A click near a corner of the chosen feature moves nothing; dragged, the corner goes as far as the pointer, wherever it was taken hold of. */
async function cornerDragged(page, get) {
  const screen = await onScreen(page); // with other tools the map lies elsewhere
  const corner = async () => screen((await get("drawing")).features[1].vertices[0].position);
  const [x, y] = await corner();
  const { number } = await get("edits");
  await page.mouse.click(x + 4, y);
  await quiet(page, 400); // longer than a double click takes
  assert.equal((await get("edits")).number, number);
  const asked = page.waitForResponse((response) => response.request().method() === "POST" && response.url().endsWith("/edits"));
  await page.mouse.move(x + 4, y);
  await page.mouse.down();
  await page.mouse.move(x + 24, y - 10, { steps: 4 });
  await page.mouse.up();
  await asked;
  const off = Math.hypot(...(await corner()).map((value, axis) => value - [x + 20, y - 10][axis]));
  assert.ok(off < 1.5, `${off} px`); // the pointer is at whole pixels
  // No feature is chosen then: of one that is undone no figures are asked for.
  const box = await page.getByRole("application").boundingBox();
  await page.mouse.click(box.x + box.width - 30, box.y + box.height - 30);
  await page.getByRole("heading", { name: /^F2/ }).waitFor({ state: "detached" });
}

export const drawingTests = {
  // Of 12 coordinates that err independently 10 and more lie within two standard deviations but once in 500; errors of poses are alike.
  async "corners of a roof lie within two standard deviations, by marks in two photographs, in one, and on the map"({ page, context, folder, project }) {
    const { post, get } = api(context, page, project);
    const roof = await roofOf(join(folder, "..", "survey"));
    const ids = Object.fromEntries((await get("images")).images.map((image) => [image.file, image.id]));
    const normal = normals();
    const mark = (file, corner) => ({ image: ids[file], pixel: roof.pixel(file, corner).map((value) => value + 0.3 * normal()), sigma_px: 0.3 });
    const ways = {
      stereo: (corner) => ({ marks: [mark("IMG_0001.jpg", corner), mark("IMG_0005.jpg", corner)] }),
      mono: (corner) => ({ marks: [mark("IMG_0002.jpg", corner)] }),
      surface: (corner) => ({ surface: corner.slice(0, 2) }),
    };
    const counts = {};
    for (const [source, way] of Object.entries(ways)) {
      const { vertices } = await post("vertices", { vertices: roof.corners.map(way) });
      assert.deepEqual(vertices.map((one) => one.source), Array(4).fill(source), JSON.stringify(vertices));
      counts[source] = within(vertices, roof.corners);
    }
    console.log(`        coordinates of corners within two standard deviations, of 12: ${JSON.stringify(counts)}`);
    for (const [source, count] of Object.entries(counts)) assert.ok(count >= 10, `${source}: ${count} of 12`);
    // A true side of the roof, by what both ends have in common.
    const [a, b] = roof.corners;
    const side = Math.hypot(...a.map((value, axis) => value - b[axis]));
    const measured = await post("figures", { kind: "distance", vertices: [a, b].map(ways.stereo) });
    assert.ok(Math.abs(measured.value - side) < 3 * measured.sigma && measured.sigma < 0.1, `${side}: ${JSON.stringify(measured)}`);
  },

  async "a roof is drawn in a photograph and on the map, measured, written to files, and undone"({ page, context, folder, project, program, shots }) {
    const { get } = api(context, page, project);
    const roof = await roofOf(join(folder, "..", "survey"));
    const image = (await get("images")).images.find((one) => one.file === "IMG_0002.jpg");
    const before = (await get("edits")).number;
    await page.goto(`${page.url().split("#")[0]}#/${project.id}/photographs/${image.id}`);
    await page.getByText("IMG_0002.jpg").first().waitFor();
    await page.keyboard.press("v");
    await page.getByLabel("Code").selectOption("R");
    await page.getByRole("button", { name: "Fit" }).click();
    const box = await settled(page);
    const under = async (x, y) => {
      await page.mouse.move(x - 1, y);
      await page.mouse.move(x, y);
      await isDrawn(page);
      return [...(await page.locator(".readout").first().innerText()).matchAll(/[xy]\s+(-?\d+\.\d+)/g)].map((found) => Number(found[1]));
    };
    const [left, top, right, bottom] = [box.x + 0.3 * box.width, box.y + 0.35 * box.height, box.x + 0.7 * box.width, box.y + 0.65 * box.height];
    const [[x0, y0], [x1, y1]] = [await under(left, top), await under(right, bottom)];
    const scale = (right - left) / (x1 - x0);
    const places = roof.corners.map((corner) => {
      const [x, y] = roof.pixel(image.file, corner);
      return [left + scale * (x - x0), top + ((bottom - top) / (y1 - y0)) * (y - y0)];
    });
    await clickAll(page, places, 1);
    const [drawn] = (await get(`drawing?image=${image.id}`)).features;
    assert.equal(drawn.kind, "polygon");
    assert.equal(drawn.attributes.code, "R");
    drawn.vertices.forEach((vertex, i) => {
      const away = Math.hypot(...roof.pixel(image.file, roof.corners[i]).map((value, axis) => value - vertex.marks[0].pixel[axis]));
      assert.ok(away < 1.5 / scale, `corner ${i} was clicked ${away} px off`); // a click is at a whole pixel of the screen
    });
    await page.screenshot({ path: join(shots, "drawn-photograph.png") });

    await page.getByRole("navigation", { name: "Views" }).getByRole("link", { name: "Map", exact: true }).click();
    await page.getByLabel("Orthophoto", { exact: true }).waitFor();
    const screen = await onScreen(page);
    await page.getByLabel("Snap").uncheck();
    await clickAll(page, roof.corners.map(screen), 2);
    await page.screenshot({ path: join(shots, "drawn-map.png") });
    await page.getByRole("button", { name: "Measure", exact: true }).click();
    await page.getByLabel("Snap").check();
    for (const corner of roof.corners.slice(0, 2)) await page.mouse.click(...screen(corner));
    await page.getByText(/^\d+\.\d+ ± \d+\.\d+ m$/).first().waitFor();
    await page.keyboard.press("Escape");
    await page.keyboard.press("Escape");

    execFileSync(program, ["plot", folder, "--progress", "none"], { stdio: "ignore" });
    for (const [file, part] of [["drawing.gpkg", "roof_polygon"], ["drawing.dxf", "entities"]]) {
      const info = spawnSync("ogrinfo", ["-so", "-al", join(folder, "products", file)], { encoding: "utf8" });
      if (info.error) continue; // not installed: the program's own tests read both by GDAL
      assert.match(info.stdout, new RegExp(part));
      if (file.endsWith("gpkg")) assert.match(info.stdout, /32633/);
      else assert.match(info.stdout, /Feature Count: 2/);
    }

    await cornerDragged(page, get);

    await page.getByRole("application").focus();
    for (let edits = (await get("edits")).number - before; edits > 0; --edits) {
      const asked = page.waitForResponse((response) => response.request().method() === "POST" && response.url().endsWith("/edits"));
      await page.keyboard.press("Control+z");
      await asked;
    }
    assert.deepEqual((await get("drawing")).features, []);
  },
};
