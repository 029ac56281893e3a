// SPDX-License-Identifier: Apache-2.0
// views.mjs FOLDER: the views of photographs and control in a browser, with answers of a made-up block whose truth is known. The page is
// built in FOLDER. Ends with 77 (skipped) where there is no browser. Screenshots stay in FOLDER/screenshots.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join, resolve } from "node:path";

import { controlTests } from "./control_tests.mjs";
import { base, mockStation } from "./mock_station.mjs";
import { photographTests } from "./photograph_tests.mjs";
import { countRequests } from "./quiet.mjs";
import { browserAt, startBrowser } from "./station.mjs";

const folder = resolve(process.argv[2] ?? "");
const only = process.argv[3] ?? "";
const require = createRequire(import.meta.url);
const [chromium, build] = await Promise.all([
  import("playwright-core").then((module) => module.chromium).catch(() => undefined),
  import("vite").then((module) => module.build).catch(() => undefined),
]);
if (!browserAt || !chromium || !build) {
  console.log("skipped: no chromium, or web/node_modules is not there");
  process.exit(77);
}
const built = join(folder, "page");
const shots = join(folder, "screenshots");
mkdirSync(shots, { recursive: true });
await build({ logLevel: "error", build: { outDir: built, emptyOutDir: true } });

const axe = readFileSync(require.resolve("axe-core/axe.min.js"), "utf8");

/** Nothing serious against the rules of accessibility. */
async function judge(page, what) {
  if (!(await page.evaluate(() => "axe" in globalThis))) await page.evaluate(axe);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { iframes: false, resultTypes: ["violations"] }));
  const serious = violations.filter((one) => ["serious", "critical"].includes(one.impact));
  for (const one of serious) console.log(`${what}: ${one.id}: ${one.help}\n  ${one.nodes.map((node) => `${node.html}\n    ${node.failureSummary}`).join("\n  ")}`);
  assert.deepEqual(serious.map((one) => one.id), [], what);
}

const browser = await startBrowser(chromium);
let failed = 0;
for (const [name, test] of Object.entries({ ...photographTests, ...controlTests })) {
  if (!name.includes(only)) continue;
  const began = Date.now();
  const context = await browser.newContext({ reducedMotion: "reduce", viewport: { width: 1280, height: 800 }, locale: "en-GB" });
  context.setDefaultTimeout(20_000);
  countRequests(context);
  const complaints = [];
  context.on("console", (message) => {
    // What is refused on purpose is told by the browser, too.
    if (message.type() === "error" && !/status of 4(09|22)/.test(message.text())) complaints.push(`console: ${message.text()} (${message.location().url})`);
  });
  context.on("weberror", (error) => complaints.push(`page: ${error.error().stack}`));
  const world = await mockStation(context, built);
  const page = await context.newPage();
  try {
    const open = (view, tab = page) => tab.goto(`${base}/#/p1/${view}`);
    const shot = (name) => page.screenshot({ path: join(shots, `${name}.png`) });
    await test({ page, context, world, open, shot, judge: (what) => judge(page, what) });
    assert.deepEqual([...new Set(complaints)], []);
    console.log(`ok      ${name} (${((Date.now() - began) / 1000).toFixed(1)} s)`);
  } catch (error) {
    ++failed;
    console.log(`FAILED  ${name}\n${error.stack}\n  ${complaints.join("\n  ")}`);
    await page.screenshot({ path: join(shots, `failed-${failed}.png`) }).catch(() => {});
  }
  await context.close();
}
await browser.close();
console.log(failed ? `${failed} failed; see ${shots}` : "all passed");
process.exit(failed ? 1 : 0);
