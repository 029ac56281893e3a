// SPDX-License-Identifier: Apache-2.0
// Masks drawn in a photograph and patches drawn on the map, against a real server.
import assert from "node:assert/strict";

const rail = (page, name) => page.getByRole("navigation", { name: "Views" }).getByRole("link", { name, exact: true });
const workOf = (page, id) => page.evaluate(async (path) => (await fetch(path)).json(), `/api/projects/${id}/work`);

/** Asks until it holds: what was clicked is on its way. */
async function until(page, holds) {
  for (let i = 0; i < 200; ++i) {
    if (await holds()) return;
    await page.waitForTimeout(50);
  }
  assert.ok(await holds(), String(holds));
}

async function clicked(page, target, places) {
  const box = await target.boundingBox();
  for (const [x, y] of places) await page.mouse.click(box.x + x * box.width, box.y + y * box.height);
}

export const workTests = {
  async "a mask is drawn in a photograph, chosen, removed and brought back"({ page, project }) {
    await page.goto(`${page.url().split("#")[0]}#/${project.id}/photographs/1`);
    const target = page.getByRole("application");
    await target.locator("canvas").first().waitFor();
    await page.keyboard.press("m");
    await clicked(page, target, [[0.4, 0.4], [0.6, 0.42], [0.5, 0.6], [0.3, 0.3]]);
    await page.keyboard.press("Backspace"); // the last corner
    await page.keyboard.press("Enter");
    await until(page, async () => (await workOf(page, project.id)).masks.length === 1);
    const [mask] = (await workOf(page, project.id)).masks;
    assert.equal(mask.image, 1);
    assert.equal(mask.ring.length, 3);
    for (const [x, y] of mask.ring) assert.ok(x > 0 && y > 0 && x < 640 && y < 480, `${x} ${y}`);
    await page.getByText("1 masks; they hold when the steps are run again").waitFor();
    await page.keyboard.press("Delete"); // the new one is chosen
    await until(page, async () => (await workOf(page, project.id)).masks.length === 0);
    await page.keyboard.press("Control+z");
    await until(page, async () => (await workOf(page, project.id)).masks.length === 1);
    assert.deepEqual((await workOf(page, project.id)).masks[0].ring, mask.ring);
    await page.keyboard.press("Control+z");
    await until(page, async () => (await workOf(page, project.id)).masks.length === 0);
    await page.keyboard.press("m");
  },

  async "a patch is drawn on the map, taken from another photograph, and removed"({ page, project }) {
    await rail(page, "Map").click();
    const target = page.getByRole("application");
    await page.getByLabel("Orthophoto", { exact: true }).waitFor();
    await page.getByLabel("Draw patches").check();
    await clicked(page, target, [[0.4, 0.4], [0.6, 0.4], [0.6, 0.6], [0.4, 0.6]]);
    await page.getByText("4 corners", { exact: false }).waitFor();
    await page.getByRole("button", { name: "Finish patch" }).click();
    await until(page, async () => (await workOf(page, project.id)).patches.length === 1);
    const [patch] = (await workOf(page, project.id)).patches;
    const held = page.getByLabel("Photograph of S1");
    assert.equal(await held.inputValue(), patch.file);
    const others = (await held.locator("option").allInnerTexts()).filter((file) => file !== patch.file);
    await held.selectOption(others[0]);
    await until(page, async () => (await workOf(page, project.id)).patches[0].file === others[0]);
    assert.equal((await workOf(page, project.id)).patches[0].ring.length, 4);
    await page.getByRole("button", { name: "Remove S1" }).click();
    await until(page, async () => (await workOf(page, project.id)).patches.length === 0);
    await page.getByLabel("Draw patches").uncheck();
  },
};
