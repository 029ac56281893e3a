// SPDX-License-Identifier: Apache-2.0
// page.mjs PROGRAM FOLDER: the page of `collinea serve` in a browser, against a server of a small project that is made in FOLDER.
// Ends with 77 (skipped) where there is no browser. Screenshots of every view stay in FOLDER/screenshots.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

import { drawingTests } from "./drawing_tests.mjs";
import { readValue } from "./height.mjs";
import { countRequests, quiet } from "./quiet.mjs";
import { sceneTests } from "./scene_tests.mjs";
import { standIn } from "./stand_in.mjs";
import { browserAt, makeProject, serve, startBrowser } from "./station.mjs";
import { stereoTests } from "./stereo_tests.mjs";
import { workTests } from "./work_tests.mjs";

const [program, folder] = process.argv.slice(2).map((path) => resolve(path));
const require = createRequire(import.meta.url);
const chromium = await import("playwright-core").then((module) => module.chromium).catch(() => undefined);
if (!browserAt || !chromium) {
  console.log("skipped: no chromium, or web/node_modules is not there");
  process.exit(77);
}

const views = ["project", "map", "scene", "photographs", "stereo", "control", "jobs"];
const sizes = [{ width: 1280, height: 800 }, { width: 1920, height: 1080 }];
const complaints = [];
let base = "";

/** Everything that goes wrong in a page, and every request beyond this server. */
function watch(context) {
  context.on("request", (request) => {
    const url = new URL(request.url());
    if (!["data:", "blob:"].includes(url.protocol) && url.origin !== base) complaints.push(`a request to ${url.origin}`);
  });
  context.on("console", (message) => {
    // A mark that cannot be set on the ground is refused on purpose, and the browser tells it, too.
    const isRefusal = /status of 422/.test(message.text()) && message.location().url.endsWith("/ground");
    if (message.type() === "error" && !isRefusal) complaints.push(`console: ${message.text()} (${message.location().url})`);
  });
  context.on("weberror", (error) => complaints.push(`page: ${error.error().stack}`));
}

const rail = (page, name) => page.getByRole("navigation", { name: "Views" }).getByRole("link", { name, exact: true });
const field = (page, name) => page.getByRole("textbox", { name: new RegExp(`^${name}`) });
const stepRow = (page, name) => page.getByRole("row").filter({ has: page.getByRole("link", { name, exact: true }) });

async function jobIs(page, state, number) {
  await rail(page, "Jobs").click();
  const rows = page.locator("section", { has: page.getByRole("heading", { name: "Jobs" }) }).locator("tbody tr");
  await rows.filter({ has: page.locator("td:first-child", { hasText: new RegExp(`^${number}$`) }) }).getByText(state, { exact: true }).waitFor({ timeout: 120_000 });
}

const tests = {
  async "the link leads to the project"({ page, project }) {
    await page.getByRole("heading", { name: "village", level: 2 }).waitFor();
    assert.equal(new URL(page.url()).search, "", "the token does not stay in the address");
    for (const step of ["import", "detect", "match", "orient", "adjust", "densify", "surface", "terrain", "ortho", "frames", "report"])
      await stepRow(page, step).getByRole("img", { name: "done" }).waitFor();
    await page.getByText("6, 6 oriented").waitFor();
    await page.getByText("EPSG:32633", { exact: true }).waitFor();
    const ortho = page.getByRole("link", { name: "ortho.tif", exact: true });
    assert.equal(await ortho.getAttribute("href"), `/api/projects/${project.id}/files/products/ortho.tif`);
  },

  async "an option is checked, only what changed is sent, and a second tab is in step"({ page, second }) {
    await rail(page, "Project").click();
    await stepRow(page, "ortho").getByRole("link", { name: "ortho" }).click();
    const feather = field(page, "feather_cells");
    const run = page.getByRole("region", { name: "The step ortho" }).getByRole("button", { name: /^Run to here/ });
    await feather.fill("1");
    await page.getByText("At least 2 cells.").waitFor();
    assert.equal(await feather.getAttribute("aria-invalid"), "true");
    assert.ok(await run.isDisabled());
    await feather.fill("8");
    await stepRow(page, "ortho").getByText("1 options edited").waitFor();
    const [asked] = await Promise.all([
      page.waitForRequest((request) => request.method() === "POST" && request.url().endsWith("/jobs")),
      run.click(),
    ]);
    assert.deepEqual(asked.postDataJSON(), { step: "ortho", options: { ortho: { feather_cells: 8 } } });
    await Promise.all([jobIs(page, "done", 1), jobIs(second, "done", 1)]);
    await second.getByRole("log").getByText(/ortho/).first().waitFor();

    for (const tab of [page, second]) {
      await rail(tab, "Project").click();
      await stepRow(tab, "ortho").getByRole("link", { name: "ortho" }).click();
      await tab.getByText("Default: 12 cells").waitFor();
      assert.equal(await field(tab, "feather_cells").inputValue(), "8");
      assert.equal(await tab.getByText("options edited").count(), 0);
    }
  },

  async "what was typed stays while other things are looked at, and goes when it is discarded"({ page }) {
    await field(page, "feather_cells").fill("20");
    await rail(page, "Jobs").click();
    await rail(page, "Project").click();
    await stepRow(page, "ortho").getByText("1 options edited").waitFor();
    await stepRow(page, "ortho").getByRole("link", { name: "ortho" }).click();
    assert.equal(await field(page, "feather_cells").inputValue(), "20");
    await page.getByRole("button", { name: "Discard edits" }).click();
    assert.equal(await field(page, "feather_cells").inputValue(), "8");
    await page.getByRole("button", { name: "feather_cells: reset to the default, 12 cells" }).click();
    assert.equal(await field(page, "feather_cells").inputValue(), "12");
    await page.getByRole("button", { name: "Discard edits" }).click();
  },

  // Features made anew: everything behind them is seconds of work, so that the stop comes in time.
  async "a run is stopped and goes on"({ page, second }) {
    await stepRow(page, "detect").getByRole("link", { name: "detect" }).click();
    await field(page, "max_features").fill("4096");
    await page.getByRole("button", { name: "Run everything" }).click();
    await page.getByRole("button", { name: "Stop", exact: true }).click();
    await page.getByText("The job up to report was stopped.").waitFor({ timeout: 60_000 });
    await rail(second, "Project").click();
    await second.getByText("The job up to report was stopped.").waitFor();
    await page.getByRole("button", { name: "Go on" }).click();
    await page.getByRole("contentinfo").getByText("village: report").waitFor();
    await jobIs(page, "done", 3);
    await rail(page, "Project").click();
    assert.equal(await page.getByText("was stopped").count(), 0);
  },

  async "the report is read inside, in a sandbox"({ page, project }) {
    const [response] = await Promise.all([
      page.waitForResponse((one) => one.url().endsWith("/files/report/report.html")),
      page.getByRole("link", { name: "Read report.html" }).click(),
    ]);
    assert.equal(response.status(), 200);
    assert.match(response.headers()["content-security-policy"], /^sandbox;/);
    const frame = page.locator("iframe");
    assert.equal(await frame.getAttribute("sandbox"), "");
    assert.equal(await frame.getAttribute("src"), `/api/projects/${project.id}/files/report/report.html`);
    await page.goBack();
  },

  async "the map shows height and sigma of a place, and who sees it"({ page, folder: project }) {
    await rail(page, "Map").click();
    const target = page.getByRole("application");
    await target.locator("canvas").first().waitFor();
    await page.getByLabel("Orthophoto", { exact: true }).waitFor();
    const painted = () =>
      page.evaluate(() => {
        let colours = 0;
        for (const canvas of document.querySelectorAll(".target canvas")) {
          const seen = new Set();
          const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
          for (let i = 0; i < data.length; i += 4 * 97) seen.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
          colours = Math.max(colours, seen.size);
        }
        return colours;
      });
    while ((await painted()) < 1000) await page.waitForTimeout(100); // an image, not a colour
    await target.focus();
    await page.keyboard.press("Enter");
    const place = page.getByRole("region", { name: "Place" });
    const text = await place.getByText(/^\s*E \d/).innerText();
    const [e, n, h, sigma] = [...text.replaceAll("±", "").matchAll(/\d+\.\d+/g)].map(Number);
    const products = join(project, "products");
    // The place is shown to a centimetre, a cell is 0.16 m: heights agree to what is shown unless that is at the rim of a cell.
    const heights = await Promise.all([-0.01, 0, 0.01].map((by) => readValue(join(products, "dsm.tif"), e + by, n + by)));
    assert.ok(heights.some((height) => Math.abs(height - h) < 0.006), `${h} m of ${heights}`);
    const sigmas = await Promise.all([-0.01, 0, 0.01].map((by) => readValue(join(products, "dsm_sigma.tif"), e + by, n + by)));
    assert.ok(sigmas.some((one) => Math.abs(one - sigma) < 0.0006), `${sigma} m of ${sigmas}`);
    await place.getByText(/^\d photographs see it$/).waitFor();
    assert.ok((await place.getByRole("listitem").count()) >= 3);
    for (const layer of ["Surface, shaded", "Standard deviation of the surface", "Footprints", "Tie points"])
      await page.getByLabel(layer, { exact: true }).check();
    await page.getByText(/Ellipses of one standard deviation in plan, enlarged [\d,]+ ×/).waitFor();
    await page.getByLabel("Opacity: Orthophoto").fill("0.5");
    await page.getByLabel("Surface, shaded", { exact: true }).uncheck();
    await page.getByLabel("Standard deviation of the surface", { exact: true }).uncheck();
    await page.getByLabel("Opacity: Orthophoto").fill("1");
  },

  async "the map is moved and zoomed by the mouse and by keys"({ page }) {
    const scale = page.locator(".ol-scale-line-inner");
    const readout = page.locator(".readout");
    const box = await page.getByRole("application").boundingBox();
    const middle = [box.x + box.width / 2, box.y + box.height / 2];
    const changes = async (what, act) => {
      const before = await what.innerText();
      await act();
      while ((await what.innerText()) === before) await page.waitForTimeout(50);
    };
    await page.mouse.move(...middle);
    await changes(scale, () => page.mouse.wheel(0, -600));
    await changes(readout, async () => {
      await page.mouse.down();
      await page.mouse.move(middle[0] + 150, middle[1] + 90, { steps: 5 });
      await page.mouse.up();
      await page.mouse.move(...middle);
    });
    await page.getByRole("application").focus();
    await changes(scale, async () => {
      for (let i = 0; i < 3; ++i) await page.keyboard.press("+");
    });
    await page.getByRole("button", { name: "Show all" }).click();
  },

  async "the map takes up what a step made anew"({ page, second }) {
    await rail(second, "Project").click();
    await stepRow(second, "ortho").getByRole("link", { name: "ortho" }).click();
    await field(second, "cell_m").fill("0.32");
    const again = page.waitForRequest(/ortho\.tif/);
    again.catch(() => {});
    await second.getByRole("region", { name: "The step ortho" }).getByRole("button", { name: /^Run to here/ }).click();
    await jobIs(second, "done", 4);
    await again;
    assert.ok(await page.getByLabel("Orthophoto", { exact: true }).isChecked());
    await page.getByLabel("Opacity: Orthophoto").waitFor();
    await page.waitForFunction(() => document.querySelectorAll(".target canvas").length > 0);
    assert.equal(await page.getByText(/cannot be shown/).count(), 0);
  },

  ...drawingTests,
  ...workTests,
  ...sceneTests,

  async "the language is switched and kept"({ page }) {
    await page.getByLabel("Language").selectOption("de");
    await page.getByRole("navigation", { name: "Ansichten" }).getByRole("link", { name: "Karte" }).waitFor();
    assert.equal(await page.evaluate(() => document.documentElement.lang), "de");
    await page.reload();
    await page.getByLabel("Sprache").selectOption("en");
  },

  async "every view is legible and can be used without a mouse, light and dark"({ page, shots }) {
    const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");
    for (const theme of ["light", "dark"]) {
      await page.getByLabel("Theme").selectOption(theme);
      for (const view of views) {
        await page.goto(`${base}/${page.url().split("/")[3]}/${page.url().split("/")[4]}/${view}`);
        for (const size of sizes) {
          await page.setViewportSize(size);
          await quiet(page);
          await rested(page);
          await page.screenshot({ path: join(shots, `${view}-${theme}-${size.width}.png`) });
        }
        await judged(page, axe, `${view}, ${theme}`);
        if (view !== "project") continue;
        await stepRow(page, "adjust").getByRole("link", { name: "adjust" }).click();
        await field(page, "additional_level").waitFor();
        await judged(page, axe, `options, ${theme}`);
        await page.screenshot({ path: join(shots, `options-${theme}-1920.png`) });
        await page.getByLabel("Close").first().click();
        await page.getByRole("link", { name: "Read report.html" }).click();
        await quiet(page);
        await page.screenshot({ path: join(shots, `report-${theme}-1920.png`) });
      }
    }
    await page.getByLabel("Theme").selectOption("system");
  },

  async "the keyboard reaches everything, and the first key the content"({ context, project }) {
    const page = await context.newPage();
    await page.goto(`${base}/#/${project.id}/project`);
    await page.getByRole("heading", { name: "village", level: 2 }).waitFor();
    await page.keyboard.press("Tab");
    assert.equal(await page.evaluate(() => document.activeElement.textContent), "To the content");
    await page.keyboard.press("Enter");
    assert.equal(await page.evaluate(() => document.activeElement.id), "content");
    const reached = new Set();
    const here = () => page.evaluate(() => document.activeElement.textContent.trim() || document.activeElement.getAttribute("aria-label"));
    for (let i = 0; i < 60; ++i) {
      await page.keyboard.press("Tab");
      reached.add(await here());
      const seen = await page.evaluate(() => document.activeElement === document.body || getComputedStyle(document.activeElement).outlineStyle !== "none");
      assert.ok(seen, `the focus does not show on ${await here()}`);
    }
    for (const name of ["Run everything", "Read report.html", "Run to here", "ortho", "ortho.tif"]) assert.ok(reached.has(name), `${name} of ${[...reached]}`);
    await page.close();
  },

  async "what a server does not offer is said in its place"({ browser, context, project }) {
    const apart = await browser.newContext({ reducedMotion: "reduce", viewport: sizes[0], locale: "en-GB", storageState: await context.storageState() });
    await apart.route(/\/(map|images|ties|control)(\?|$)/, (route) => route.fulfill({ status: 404, json: { error: "there is nothing of this name" } }));
    const page = await apart.newPage();
    await page.goto(`${base}/#/${project.id}/map`);
    await page.getByText("Not offered by this server: the reference system, footprints and projection centres, control points.").waitFor();
    await page.getByLabel("Orthophoto", { exact: true }).waitFor();
    await page.getByRole("application").focus();
    await page.keyboard.press("Enter");
    await page.getByRole("region", { name: "Place" }).getByText(/^\s*E \d/).waitFor();
    await apart.close();
  },

  // The page asks only for what came behind the last number that it has.
  async "a lost connection is taken up again"({ context, project }) {
    const page = await context.newPage();
    const asked = [];
    let socket;
    await page.routeWebSocket(/\/api\/events/, (route) => {
      asked.push(new URL(route.url()).searchParams.get("since"));
      socket = route;
      route.connectToServer();
    });
    await page.goto(`${base}/#/${project.id}/jobs`);
    await page.getByRole("cell", { name: "4", exact: true }).waitFor();
    const lines = await page.getByRole("log").locator("div").count();
    await socket.close();
    await page.getByText("no connection to the server; trying again").waitFor();
    await page.getByText("connected", { exact: true }).waitFor();
    assert.equal(asked[0], "0");
    assert.ok(Number(asked.at(-1)) > 0, `since=${asked}`);
    assert.equal(await page.getByRole("log").locator("div").count(), lines);
    await page.close();
  },
};

/** Until what is drawn in 3D is there. */
const rested = (page) => page.locator('[role="application"][aria-busy="true"]').waitFor({ state: "detached" });

async function judged(page, axe, what) {
  if (!(await page.evaluate(() => "axe" in globalThis))) await page.evaluate(axe);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { iframes: false, resultTypes: ["violations"] }));
  const serious = violations.filter((one) => ["serious", "critical"].includes(one.impact));
  for (const one of serious) console.log(`${what}: ${one.id}: ${one.help}\n  ${one.nodes.map((node) => `${node.html}\n    ${node.failureSummary}`).join("\n  ")}`);
  assert.deepEqual(serious.map((one) => one.id), [], what);
}

/** A server that ends is missed; another one at its place lets nobody in without its link, and has no jobs yet. */
async function otherServer(page, context) {
  await page.goto(`${page.url().split("#")[0]}#/${page.url().split("/")[4]}/jobs`);
  await page.getByRole("cell", { name: "4", exact: true }).waitFor();
  await server.end();
  await page.getByText("no connection to the server; trying again").waitFor();
  server = await serve(program, project, Number(new URL(base).port));
  await page.getByText("no longer let in: open the link that collinea serve showed last").waitFor();
  const second = await context.newPage();
  await second.goto(server.link);
  await page.bringToFront();
  await page.getByText("connected", { exact: true }).waitFor();
  await page.getByText(/^No jobs yet/).waitFor();
  console.log("ok      another server is another one");
}

const only = process.env.ONLY; // tests whose names have this; all otherwise
const project = makeProject(program, folder);
let server = await serve(program, project);
base = server.base;
const shots = join(folder, "screenshots");
mkdirSync(shots, { recursive: true });
const browser = await startBrowser(chromium);
let failed = 0;
try {
  const context = await browser.newContext({ reducedMotion: "reduce", viewport: sizes[0], locale: "en-GB" });
  watch(context);
  countRequests(context);
  const page = await context.newPage();
  await page.goto(server.link);
  await page.waitForURL(`${base}/#/**`);
  const held = await standIn(context, base, project);
  // In a window of its own: of the tabs of one window those behind get one frame a second.
  const elsewhere = await browser.newContext({ reducedMotion: "reduce", viewport: sizes[0], locale: "en-GB", storageState: await context.storageState() });
  watch(elsewhere);
  const second = await elsewhere.newPage();
  await second.goto(base);
  for (const [name, test] of Object.entries({ ...tests, ...stereoTests }).filter(([name]) => !only || new RegExp(only).test(name))) {
    const began = Date.now();
    try {
      await test({ page, second, context, browser, folder: project, project: held, survey: join(folder, "survey"), program, shots });
      console.log(`ok      ${name} (${((Date.now() - began) / 1000).toFixed(1)} s)`);
    } catch (error) {
      ++failed;
      console.log(`FAILED  ${name}\n${error?.stack ?? error}`);
      await page.screenshot({ path: join(shots, `failed-${failed}.png`) });
    }
  }
  if (complaints.length) {
    ++failed;
    console.log(`FAILED  no errors, and no request beyond the server\n  ${[...new Set(complaints)].join("\n  ")}`);
  }
  if (!only) await otherServer(page, context);
} catch (error) {
  ++failed;
  console.log(`FAILED  ${error.stack}`);
} finally {
  await browser.close();
  await server.end();
}
console.log(failed ? `${failed} failed; see ${shots}` : "all passed");
process.exit(failed ? 1 : 0);
