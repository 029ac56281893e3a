// SPDX-License-Identifier: Apache-2.0
import assert from "node:assert/strict";

import { images, truePixel } from "./mock_world.mjs";
import { cursorOf } from "./photograph_tests.mjs";
import { quiet } from "./quiet.mjs";

const photo = (page, point, file) => page.getByRole("application", { name: `${point} in ${file}` });
const pointRow = (page, name) => page.getByRole("table", { name: "Control and check points" }).getByRole("row").filter({ has: page.getByRole("button", { name, exact: true }) });
const status = (page, text) => page.locator(".foot").getByText(text);
const marksOf = (world, name) => Object.entries(world.points.get(name)?.marks ?? {});
const byFile = (file) => images.find((image) => image.file === file);

/** Until something holds; the test ends with the time limit of the page else. */
export async function until(page, holds) {
  for (let i = 0; i < 400 && !(await holds()); ++i) await page.waitForTimeout(25);
  assert.ok(await holds(), holds.toString());
}

const missOf = (name, file, mark) => Math.hypot(...truePixel(name, byFile(file)).map((one, axis) => one - mark.pixel[axis]));

/** The point and the photograph that are marked now. */
export async function shown(page) {
  const label = await page.getByRole("application").getAttribute("aria-label");
  return label.split(" in ");
}

/** Where a pixel of the photograph is on the screen; the pointer is over it afterwards. */
export async function screenOf(page, pixel) {
  const box = await page.getByRole("application").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2].map(Math.round);
  await page.mouse.move(x + 1, y);
  await page.mouse.move(x, y);
  await until(page, async () => (await cursorOf(page)).length === 2);
  const at = await cursorOf(page);
  const scale = Number((await page.locator(".readout .number").innerText()).replace(/[^\d]/g, "")) / 100;
  return [x + (pixel[0] - at[0]) * scale, y + (pixel[1] - at[1]) * scale];
}

export const controlTests = {
  // Six marks of each of ten points. Nine have targets at their predicted places; those of the tenth lie 14 px off, and are clicked.
  async "sixty marks take at most 130 events of a person, and lie where the targets are"({ page, open, world, shot }) {
    await open("control");
    await photo(page, "P1", "").or(page.getByRole("application")).waitFor();
    let events = 0;
    const press = (key) => (++events, page.keyboard.press(key));
    for (let at = 1; at <= 10; ++at)
      for (let mark = 0; mark < 6; ++mark) {
        await until(page, async () => (await shown(page))[0] === `P${at}`);
        const [name, file] = await shown(page);
        if (name === "P10") {
          const [x, y] = await screenOf(page, truePixel(name, byFile(file)));
          await page.mouse.move(x, y);
          await press("Space"); // measured under the pointer
          await until(page, () => marksOf(world, name).length === mark + 1);
        }
        await press("Enter");
        await until(page, async () => marksOf(world, name).length === mark + 1 && (mark === 5 || (await shown(page))[1] !== file));
      }
    await status(page, "All points have enough marks.").waitFor();
    await shot("control-marked");
    console.log(`        ${events} events for 60 marks`);
    assert.ok(events <= 130, `${events} events`);
    for (const [name, point] of world.points)
      for (const [file, mark] of Object.entries(point.marks)) {
        const miss = missOf(name, file, mark);
        assert.ok(miss < 0.05, `${name} in ${file}: ${miss} px`); // the mock measures to 0.03 px in each coordinate
        assert.ok(mark.sigma_px >= 0.04 && mark.sigma_px <= 0.05, "the sigma is that of the measurement");
      }
    assert.equal([...world.points.values()].reduce((sum, point) => sum + Object.keys(point.marks).length, 0), 60);
  },

  async "a click marks where it is, a drag moves, keys measure, remove, undo and redo"({ page, open, world }) {
    await open("control");
    await page.getByRole("application").waitFor();
    const [name, file] = await shown(page);
    const truth = truePixel(name, byFile(file));
    const [x, y] = await screenOf(page, [truth[0] + 20, truth[1] + 10]);
    await page.mouse.click(x, y);
    await until(page, () => marksOf(world, name).length === 1);
    let [, mark] = marksOf(world, name)[0];
    assert.ok(Math.hypot(mark.pixel[0] - truth[0] - 20, mark.pixel[1] - truth[1] - 10) < 0.8, `${mark.pixel}`); // a pixel of the screen is half a one of the photograph
    assert.equal(mark.sigma_px, 0.5, "the server gives its own sigma");
    await page.locator(".readout").getByText("marked, ± 0.50 px").waitFor();

    await page.mouse.move(x + 2, y + 2);
    await page.mouse.down();
    await page.mouse.move(x - 20, y - 10, { steps: 5 });
    await page.mouse.move(x + 2 - 40, y + 2 - 20, { steps: 5 });
    await page.mouse.up();
    await until(page, () => world.number === 2);
    [, mark] = marksOf(world, name)[0];
    assert.ok(Math.hypot(mark.pixel[0] - truth[0], mark.pixel[1] - truth[1]) < 1, `dragged to ${mark.pixel}, not ${truth}`);

    await page.keyboard.press("r");
    await until(page, () => world.number === 3);
    assert.ok(missOf(name, file, marksOf(world, name)[0][1]) < 0.05);
    await status(page, /chequerboard, ± 0\.04\d px/).waitFor();
    await page.keyboard.press("Delete");
    await until(page, () => marksOf(world, name).length === 0);

    await page.keyboard.press("Control+z");
    await until(page, () => marksOf(world, name).length === 1);
    await status(page, `Undone: unmark ${name} ${file}`).waitFor();
    await page.keyboard.press("Control+Shift+z");
    await until(page, () => marksOf(world, name).length === 0);
    await page.getByRole("button", { name: "Undo" }).click();
    await until(page, () => marksOf(world, name).length === 1);
    await page.keyboard.press("Enter"); // goes on, and does not press the button again
    await until(page, async () => (await shown(page))[1] !== file);
    assert.equal(marksOf(world, name).length, 1);
    await page.keyboard.press("h");
    const history = page.getByRole("region", { name: "History" });
    await history.getByText(`unmark ${name} ${file}`, { exact: true }).waitFor();
    assert.equal(await history.getByRole("listitem").count(), 4);
    assert.match(await history.getByRole("listitem").first().innerText(), /undone/);
  },

  async "where no target is nothing is marked, and a word says so"({ page, open, world }) {
    await open("control");
    await page.getByRole("application").waitFor();
    await page.keyboard.press("o"); // P10, whose targets are too far from their predicted places
    await until(page, async () => (await shown(page))[0] === "P10");
    await page.keyboard.press("Enter");
    await status(page, "No target was found here").waitFor();
    assert.equal(world.number, 0);
  },

  async "a block that is not oriented is marked by clicks in all its photographs"({ page, open, world }) {
    world.isOriented = false;
    await open("control");
    await page.getByText("the images are not oriented yet").waitFor();
    const list = page.getByRole("list", { name: "Photographs that show P1" });
    assert.equal(await list.getByRole("button").count(), 16);
    await page.keyboard.press("Enter"); // nothing is predicted, so nothing is accepted
    for (const file of ["DJI_0001.jpg", "DJI_0002.jpg"]) {
      await until(page, async () => (await shown(page))[1] === file);
      const box = await page.getByRole("application").boundingBox();
      await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
      await until(page, () => marksOf(world, "P1").some(([name]) => name === file));
      await page.keyboard.press("Enter");
    }
    assert.equal(world.number, 2);
    await until(page, async () => (await shown(page))[1] === "DJI_0003.jpg");
  },

  async "a mark that contradicts the others is named"({ page, open, world }) {
    for (const at of [2, 3, 4]) world.edit(["mark", "P1", images[at].file, ...truePixel("P1", images[at]).map((one) => String(one + (at === 3 ? 30 : 0))), "0.08"]);
    await open("control");
    await page.getByRole("table", { name: "Marks of P1" }).getByRole("row").filter({ hasText: "DJI_0004.jpg" }).getByText("contradicts").waitFor();
    await page.getByRole("button", { name: /DJI_0004.jpg contradicts/ }).waitFor();
  },

  async "a refused edit leaves everything as it was"({ page, open, world }) {
    await open("control");
    await page.getByRole("application").waitFor();
    const [name] = await shown(page);
    await page.route("**/edits", (route) => (route.request().method() === "POST" ? route.fulfill({ status: 422, json: { error: "the journal is locked" } }) : route.fallback()));
    await page.keyboard.press("Enter");
    await status(page, "the journal is locked").waitFor();
    await until(page, async () => (await pointRow(page, name).getByRole("cell").nth(2).innerText()) === "0");
    assert.equal(world.number, 0);
  },

  async "two tabs stay in step"({ page, context, open, world }) {
    const second = await context.newPage();
    await open("control");
    await open("control", second);
    await second.getByRole("application").waitFor();
    await page.getByRole("application").waitFor();
    const [name] = await shown(page);
    await page.bringToFront();
    for (let i = 1; i <= 2; ++i) {
      await page.keyboard.press("Enter");
      await until(page, () => marksOf(world, name).length === i);
    }
    await until(second, async () => (await pointRow(second, name).getByRole("cell").nth(2).innerText()) === "2");
    await second.getByRole("table", { name: `Marks of ${name}` }).getByRole("row").nth(2).waitFor();
    await second.getByRole("button", { name: "Undo" }).click();
    await until(page, async () => (await pointRow(page, name).getByRole("cell").nth(2).innerText()) === "1");
  },

  async "points are added, changed, removed, and take another role"({ page, open, world }) {
    await open("control");
    await page.getByRole("application").waitFor();
    await page.getByRole("button", { name: "+ Point" }).click();
    const form = page.getByRole("form", { name: "Add a point" });
    await form.getByLabel("Name").fill("P1");
    await form.getByRole("button", { name: "Save" }).click();
    await form.getByText("There is a point of this name already.").waitFor();
    await form.getByLabel("Name").fill("new point");
    for (const [axis, value] of [["E", "500010.5"], ["N", "5300002"], ["H", "51"]]) await form.getByLabel(`${axis} [m]`, { exact: true }).fill(value);
    await form.getByLabel("Standard deviation of E [m]").fill("0.01");
    await form.getByRole("button", { name: "Save" }).click();
    await form.getByText("Give standard deviations of all coordinates, or of none.").waitFor();
    await form.getByLabel("Standard deviation of E [m]").fill("");
    await form.getByRole("button", { name: "Save" }).click();
    await page.getByRole("heading", { name: "new point" }).waitFor();
    assert.deepEqual(world.entries.at(-1).command, ["point", "new point", "control", "500010.5", "5300002", "51"]);
    await page.getByRole("radio", { name: "check point" }).check();
    await until(page, () => world.points.get("new point")?.role === "check");
    await page.getByRole("button", { name: "Change …" }).click();
    await page.getByRole("form", { name: "Change new point" }).getByLabel("H [m]", { exact: true }).fill("52.25");
    await page.getByRole("form").getByRole("button", { name: "Save" }).click();
    await until(page, () => world.points.get("new point")?.position[2] === 52.25);
    await page.getByRole("button", { name: "Remove" }).click();
    await until(page, () => !world.points.has("new point"));
    await until(page, async () => (await pointRow(page, "new point").count()) === 0);
  },

  async "the table is sorted and shows what is beyond its limit"({ page, open, world }) {
    for (const at of [0, 1]) world.edit(["mark", "P2", images[at + 2].file, ...truePixel("P2", images[at + 2]).map((one) => String(one + at)), "0.1"]);
    await open("control");
    await pointRow(page, "P5").getByText("H −0.081 ± 0.019").waitFor();
    assert.match(await pointRow(page, "P5").getByText("H −0.081").getAttribute("class"), /doubted/);
    assert.match(await pointRow(page, "P2").getByRole("cell").last().getAttribute("class"), /doubted/);
    const first = async () => await page.getByRole("table", { name: "Control and check points" }).getByRole("row").nth(1).getByRole("cell").first().innerText();
    await page.getByRole("button", { name: "Difference [m]" }).click();
    assert.equal(await first(), "P5");
    await page.getByRole("button", { name: "|w|" }).click();
    assert.equal(await first(), "P2");
    await page.getByRole("button", { name: "Name" }).click();
    assert.equal(await first(), "P1");
    await page.getByRole("button", { name: "Name" }).click();
    assert.equal(await first(), "P10");
  },

  async "a file is read, judged beside the block, and accepted"({ page, open, world, shot, judge }) {
    await open("control");
    await page.getByRole("link", { name: "Import …" }).click();
    const give = (name, text) => page.getByLabel("Choose a file").setInputFiles({ name, mimeType: "text/plain", buffer: Buffer.from(text) });
    const rows = [["A1", 500010.25, 5300005.5], ["A2", 500040, 5300010]];
    await give("swapped.csv", "name;y;x;z\n" + rows.map(([name, e, n]) => `${name};${e};${n};50`).join("\n"));
    await page.getByText("2 of 2 points lie far from the block").waitFor();
    await page.getByText("With E and N exchanged they would fit.").waitFor();
    await shot("import-swapped");
    await page.getByRole("button", { name: "Exchange E and N" }).click();
    await page.getByText("All 2 points lie at the block.").waitFor();
    await give("zone.txt", "EPSG:4326\n15.0003 47.853 50 100 200 DJI_0003.jpg B1\n15.0003 47.853 50 110 210 dji_0004.jpg B1\n15.0003 47.853 50 110 210 other.jpg B1\n");
    await page.getByText("All 1 points lie at the block.").waitFor();
    await page.getByText("1 marks are in photographs that the project does not have").waitFor();
    await page.getByLabel("Coordinates are in").selectOption("the CRS of the project, EPSG:32633");
    await page.getByText("They look like degrees.").waitFor();
    await page.getByLabel("Coordinates are in").selectOption("the CRS of the file, EPSG:4326");
    for (const theme of ["light", "dark"]) {
      await page.getByLabel("Theme").selectOption(theme);
      await page.setViewportSize(theme === "dark" ? { width: 1920, height: 1080 } : { width: 1280, height: 800 });
      await judge(`import, ${theme}`);
      await shot(`import-${theme}`);
    }
    await page.getByRole("button", { name: "Accept 1 points and 2 marks" }).click();
    await pointRow(page, "B1").waitFor();
    const point = world.points.get("B1");
    assert.ok(Math.abs(point.position[0] - 500022.4) < 1 && Math.abs(point.position[1] - 5299979) < 30, `${point.position}`);
    assert.deepEqual(Object.keys(point.marks), ["DJI_0003.jpg", "DJI_0004.jpg"]);
    assert.deepEqual(point.marks["DJI_0003.jpg"].pixel, [100, 200]);
  },

  async "a file that is dropped on the view is read, and the point stays chosen meanwhile"({ page, open }) {
    await open("control");
    await page.getByRole("application").waitFor();
    await page.keyboard.press("p");
    await until(page, async () => (await shown(page))[0] === "P2");
    const dataTransfer = await page.evaluateHandle(() => {
      const data = new DataTransfer();
      data.items.add(new File(["C1\t500000\t5300000\t50\nC2\t500010\t5300000\t50\n"], "dropped.txt", { type: "text/plain" }));
      return data;
    });
    await page.dispatchEvent(".control", "drop", { dataTransfer });
    await page.getByText("dropped.txt").waitFor();
    await page.getByText("2 rows, separated by tabs").waitFor();
    await page.getByLabel("Meaning of column 4").selectOption("sigma E");
    await page.getByText("2 rows are not clear").waitFor(); // N has no sigma then
    await page.getByRole("button", { name: "Cancel" }).click();
    await until(page, async () => (await shown(page))[0] === "P2");
  },

  async "control is legible and can be used without a mouse, light and dark"({ page, open, world, shot, judge }) {
    for (const at of [2, 3, 4]) world.edit(["mark", "P1", images[at].file, ...truePixel("P1", images[at]).map((one) => String(one + 0.06 * at)), "0.08"]);
    await open("control");
    await page.getByRole("table", { name: "Marks of P1" }).waitFor();
    for (const theme of ["light", "dark"]) {
      await page.getByLabel("Theme").selectOption(theme);
      for (const [width, height] of [[1280, 800], [1920, 1080]]) {
        await page.setViewportSize({ width, height });
        const box = await page.getByRole("application").boundingBox();
        await page.mouse.move(box.x + box.width / 2 - 8, box.y + box.height / 2 - 8);
        await quiet(page);
        await shot(`control-${theme}-${width}`);
      }
      await judge(`control, ${theme}`);
    }
    await page.keyboard.press("h");
    await judge("history");
    await page.getByRole("button", { name: "+ Point" }).click();
    await judge("form of a point");
    await page.setViewportSize({ width: 1280, height: 800 });
    await page.getByLabel("Language").selectOption("de");
    await page.keyboard.press("Escape");
    await shot("control-de-1280");
  },
};
