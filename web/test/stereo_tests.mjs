// SPDX-License-Identifier: Apache-2.0
// The stereoplotter against a server of a rendered project whose surface is known.
import assert from "node:assert/strict";
import { join } from "node:path";

import { rasterOf } from "./height.mjs";

const marked = (page) => page.locator("[data-mark]").evaluate((element) => JSON.parse(element.dataset.mark));
const painted = (page) => page.waitForFunction(() => Number(document.querySelector(".stage")?.dataset.painted) > 0);

/** Goes to a place of the map; the mark stands on the surface model there. */
async function goTo(page, project, [east, north]) {
  const come = page.waitForResponse((one) => one.url().includes("/stereo?at="));
  await page.evaluate((hash) => (location.hash = hash), `#/${project.id}/stereo/at/${east}/${north}`);
  assert.equal((await come).status(), 200);
  await page.waitForFunction(([e, n]) => {
    const { position } = JSON.parse(document.querySelector("[data-mark]")?.dataset.mark ?? "{}");
    return position && Math.hypot(position[0] - e, position[1] - n) < 0.01;
  }, [east, north]);
}

const ask = (page, path, body) =>
  page.evaluate(async ([address, data]) => {
    const how = data ? { method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(data) } : {};
    return await (await fetch(address, how)).json();
  }, [path, body]);

/** Places in the middle of the block on open ground: where the surface is smooth for five cells about, as the truth has it. */
async function openPlaces(page, project, heightAt, count) {
  const { points } = await ask(page, `/api/projects/${project.id}/ties?most=2000`);
  const quantile = (axis, share) => points.map((one) => one[axis]).sort((a, b) => a - b)[Math.floor(share * (points.length - 1))];
  const [west, east, south, north] = [quantile(0, 0.25), quantile(0, 0.75), quantile(1, 0.25), quantile(1, 0.75)];
  const places = [];
  for (const [e, n] of points) {
    if (e < west || e > east || n < south || n > north) continue;
    const heights = [[0, 0], [-0.8, 0], [0.8, 0], [0, -0.8], [0, 0.8], [-0.8, -0.8], [0.8, 0.8]].map(([de, dn]) => heightAt(e + de, n + dn));
    const isOpen = heights.every((height) => Number.isFinite(height)) && Math.max(...heights) - Math.min(...heights) < 0.3;
    if (isOpen && places.every(([a, b]) => Math.hypot(a - e, b - n) > 2)) places.push([e, n]);
    if (places.length === count) break;
  }
  return places;
}

/** How alike the two halves of the screen are about their middles, with the second moved by some rows; the mark itself left out. */
async function alike(page, rows) {
  const png = (await page.locator(".stage canvas").screenshot()).toString("base64");
  return await page.evaluate(async ([data, moved]) => {
    const bytes = Uint8Array.from(atob(data), (one) => one.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: "image/png" }));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext("2d");
    context.drawImage(bitmap, 0, 0);
    const { data: colours } = context.getImageData(0, 0, bitmap.width, bitmap.height);
    const grey = (x, y) => colours[4 * (Math.round(y) * bitmap.width + Math.round(x)) + 1];
    const [half, middle] = [bitmap.width / 2, bitmap.height / 2];
    const pairs = [];
    for (let y = -30; y <= 30; y += 2)
      for (let x = -30; x <= 30; x += 2) if (Math.hypot(x, y) > 16) pairs.push([grey(half / 2 + x, middle + y), grey(1.5 * half + x, middle + y + moved)]);
    const mean = (k) => pairs.reduce((sum, one) => sum + one[k], 0) / pairs.length;
    const [a, b] = [mean(0), mean(1)];
    const moment = (f) => pairs.reduce((sum, one) => sum + f(one[0] - a, one[1] - b), 0);
    return moment((p, q) => p * q) / Math.sqrt(moment((p) => p * p) * moment((_, q) => q * q));
  }, [png, rows]);
}

export const stereoTests = {
  async "the best pair is shown, the mark where the core has it"({ page, project }) {
    await page.setViewportSize({ width: 900, height: 560 }); // the processor does the work of the GPU here
    await page.getByRole("navigation", { name: "Views" }).getByRole("link", { name: "Stereo" }).click();
    await painted(page);
    const box = await page.locator(".stage").boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    const acts = [() => page.keyboard.press("ArrowRight"), () => page.keyboard.press("Shift+ArrowUp"), () => page.keyboard.press("PageUp"), () => page.mouse.wheel(0, 100), () => page.keyboard.press("Shift+PageDown")];
    await page.locator(".stage").focus();
    for (const act of acts) {
      const before = JSON.stringify((await marked(page)).mark);
      await act();
      await page.waitForFunction((was) => JSON.stringify(JSON.parse(document.querySelector("[data-mark]").dataset.mark).mark) !== was, before);
      const { position, pixels } = await marked(page);
      const sides = await page.locator(".stereo aside ul a").evaluateAll((links) => links.map((link) => Number(link.hash.split("/").at(-1))));
      const { vertices } = await ask(page, `/api/projects/${project.id}/vertices`, { vertices: [{ marks: pixels.map((pixel, k) => ({ image: sides[k], pixel })) }] });
      const off = Math.hypot(...position.map((value, k) => value - vertices[0].position[k]));
      // The lattice is good to 0.05 px in each image: of 0.16 m a pixel on the ground, and as much in height by the base.
      assert.ok(off < 0.05, `${off} m`);
      for (const mark of vertices[0].marks) assert.ok(Math.hypot(...mark.residual_px) < 0.05, JSON.stringify(mark));
    }
  },

  // Nineteen of twenty are meant; fewer than 16 happen once in 400 of such twenties.
  async "heights set on the ground are within their bounds"({ page, project, survey }) {
    const heightAt = await rasterOf(join(survey, "truth", "dsm.tif"));
    const places = await openPlaces(page, project, heightAt, 26);
    let within = 0;
    let set = 0;
    for (const place of places) {
      await goTo(page, project, place);
      await page.keyboard.press("Shift+PageUp"); // by 2.5 pixels of parallax
      const answered = page.waitForResponse((one) => one.url().endsWith("/ground"));
      await page.keyboard.press("g");
      if ((await answered).status() !== 200) continue;
      await page.waitForFunction(() => JSON.parse(document.querySelector("[data-mark]").dataset.mark).matched !== null);
      const { position, sigma_m } = await marked(page);
      const truth = heightAt(position[0], position[1]);
      if (Math.abs(position[2] - truth) <= 1.96 * sigma_m[2]) ++within;
      if (++set === 20) break;
    }
    assert.equal(set, 20);
    console.log(`        ${within} of ${set} heights within 95 %`);
    assert.ok(within >= 16, `${within} of ${set} within 1.96 sigmas`);
  },

  async "both eyes see the same ground in the same rows"({ page, project, survey, shots }) {
    const [place] = await openPlaces(page, project, await rasterOf(join(survey, "truth", "dsm.tif")), 1);
    await goTo(page, project, place);
    const answered = page.waitForResponse((one) => one.url().endsWith("/ground"));
    await page.keyboard.press("g");
    assert.equal((await answered).status(), 200);
    for (const display of ["anaglyph", "anaglyph_colour", "parallel", "crossed", "interlaced", "flip", "left"]) {
      await page.getByLabel("Display").selectOption(display);
      await page.waitForTimeout(150);
      await page.screenshot({ path: join(shots, `stereo-${display}.png`) });
      if (display !== "parallel") continue;
      const same = await alike(page, 0);
      assert.ok(same > 0.8, `correlation ${same}`);
      assert.ok(same > (await alike(page, 2)) && same > (await alike(page, -2)));
    }
    await page.getByLabel("Display").selectOption("anaglyph");
  },

  async "a line drawn in stereo arrives in the journal"({ page, project }) {
    const { number } = await ask(page, `/api/projects/${project.id}/edits`);
    await page.locator(".stage").focus();
    await page.getByRole("button", { name: "Draw", exact: true }).click();
    await page.locator(".stage").focus();
    for (let k = 0; k < 3; ++k) {
      await page.keyboard.press(" ");
      await page.getByText(new RegExp(`^${k + 1} `)).first().waitFor().catch(() => {});
      await page.keyboard.press("Shift+ArrowRight");
    }
    await page.keyboard.press("Enter");
    let entries = [];
    for (let k = 0; k < 100 && entries.length === 0; ++k) {
      await page.waitForTimeout(50);
      ({ entries } = await ask(page, `/api/projects/${project.id}/edits?since=${number}`));
    }
    assert.ok(entries.length > 0, "nothing was drawn");
    const { command } = entries.at(-1);
    assert.equal(command[0], "draw");
    assert.equal(command.filter((word) => word === "stereo").length, 3);
    assert.equal(command.filter((word) => word === "mark").length, 6);
    await page.getByRole("button", { name: "Look", exact: true }).click();
  },
};
