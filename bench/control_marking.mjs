#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// Ten control points marked in six photographs each, in the page of a server of a rendered survey whose truth is known: events of a person, how far
// off places are predicted, how far off marks lie, and what the adjustment makes of them beside the control file of the survey.
//
// usage: node bench/control_marking.mjs PROGRAM FOLDER
import { execFileSync } from "node:child_process";
import { cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const web = join(dirname(fileURLToPath(import.meta.url)), "..", "web");
const { chromium } = createRequire(join(web, "package.json"))("playwright-core");
const { serve, startBrowser } = await import(join(web, "test", "station.mjs"));
const { screenOf, shown, until } = await import(join(web, "test", "control_tests.mjs"));
const { truthOf } = await import(join(web, "test", "truth.mjs"));
const [program, folder] = process.argv.slice(2).map((path) => resolve(path));
const [survey, marked, given] = ["survey", "marked", "given"].map((name) => join(folder, name));
const enough = 6;
const glance_px = 5; // a person sees that the cross is not on the target
const hand_px = 2; // how well a person points, of the photograph

let seed = 11;
const uniform = () => (seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648;
const normal = () => Math.sqrt(-2 * Math.log(uniform() || 1e-9)) * Math.cos(2 * Math.PI * uniform());
const run = (...args) => execFileSync(program, [...args, "--progress", "none"], { stdio: ["ignore", "ignore", "inherit"] });
const rms = (values) => Math.sqrt(values.reduce((sum, one) => sum + one * one, 0) / values.length);
const apart = (a, b) => Math.hypot(...a.map((value, axis) => value - b[axis]));

/** The survey, and a project of it whose control points are marked nowhere; check points are. */
function makeProjects() {
  for (const path of [survey, marked, given]) rmSync(path, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  run("simulate", survey, "--strips", "3", "--images-per-strip", "6", "--cross-strips", "0", "--width-px", "1024", "--height-px", "768",
    "--gsd-m", "0.06", "--control-points", "10", "--check-points", "8");
  const lines = readFileSync(join(survey, "control.csv"), "utf8").split("\n");
  writeFileSync(join(survey, "points.csv"), lines.filter((line) => !/^image, C/.test(line)).join("\n"));
  run("run", join(survey, "images"), "-o", marked, "--control", join(survey, "points.csv"), "--until", "adjust");
  cpSync(marked, given, { recursive: true });
  run("run", join(survey, "images"), "-o", given, "--control", join(survey, "control.csv"), "--until", "adjust");
}

async function mark(truth) {
  const server = await serve(program, marked);
  const browser = await startBrowser(chromium);
  const page = await (await browser.newContext({ viewport: { width: 1280, height: 800 }, locale: "en-GB" })).newPage();
  await page.goto(server.link);
  await page.waitForURL(/#\/[^/]+\//);
  const id = page.url().split("#/")[1].split("/")[0];
  const get = async (what) => await (await page.request.get(`${server.base}/api/projects/${id}/${what}`)).json();
  await page.goto(`${server.base}/#/${id}/control`);
  await page.getByRole("application").waitFor();
  const marksOf = async (name) => (await get("control")).points.find((one) => one.name === name).marks;
  let events = 0;
  const press = async (key) => (++events, await page.keyboard.press(key));
  const predictions = []; // of the third mark of a point and later ones [px]
  const used = { predicted: 0, pointed: 0 };
  const answered = () => page.waitForResponse((one) => /\/(refine|edits)$/.test(one.url()) && one.request().method() === "POST");
  const points = (await get("control")).points.filter((one) => one.role === "control").map((one) => one.name);
  for (const point of points) {
    for (;;) {
      await until(page, async () => (await shown(page))[0] === point);
      const [, file] = await shown(page);
      const before = await marksOf(point);
      const place = (await get(`control/${encodeURIComponent(point)}/places`)).places.find((one) => one.file.endsWith(file));
      const target = truth.pixelOfWorld(file, truth.marks[point].world);
      const off = apart(place.pixel, target);
      if (before.length >= 2) predictions.push(off);
      const isPredicted = off < glance_px;
      if (!isPredicted) {
        const pixel = target.map((value) => value + hand_px * normal());
        await page.mouse.move(...(await screenOf(page, pixel)));
        ++events;
        const made = answered();
        await press("Space"); // measured under the pointer
        await made;
        await until(page, async () => (await marksOf(point)).length === before.length + 1);
      }
      ++used[isPredicted ? "predicted" : "pointed"];
      await press("Enter");
      await until(page, async () => (await marksOf(point)).length === before.length + 1);
      const isDone = before.length + 1 === enough;
      if (isDone && point === points.at(-1)) break;
      await until(page, async () => {
        const [name, next] = await shown(page);
        return name !== point || next !== file || (await page.locator(".foot").innerText()).includes("enough marks");
      });
      if ((await shown(page))[0] !== point) break;
    }
  }
  const misses = [];
  for (const one of (await get("control")).points.filter(({ role }) => role === "control"))
    for (const { file, pixel } of one.marks) misses.push(apart(pixel, truth.pixelOfWorld(file, truth.marks[one.name].world)));
  await browser.close();
  await server.end();
  console.log(`${misses.length} marks of ${points.length} points by ${events} events (moves of the pointer counted), ${used.pointed} pointed at, ${used.predicted} by one key`);
  const near = predictions.filter((off) => off <= 10).length;
  console.log(`places from the third mark on: ${near} of ${predictions.length} within 10 px, median ${predictions.sort((a, b) => a - b)[predictions.length >> 1].toFixed(2)} px, farthest ${predictions.at(-1).toFixed(2)} px`);
  console.log(`marks: ${rms(misses).toFixed(3)} px RMS of the distance, farthest ${Math.max(...misses).toFixed(3)} px, ${misses.filter((one) => one <= 0.1).length} of ${misses.length} within 0.1 px`);
}

/** What check points of an adjustment err by, in truth and by their standard deviations. */
function judged(project, truth) {
  const [head, ...lines] = readFileSync(join(project, "adjustment", "control.csv"), "utf8").trim().split("\n").map((line) => line.split(",").map((field) => field.replaceAll('"', "").trim()));
  const rows = lines.map((line) => Object.fromEntries(head.map((name, at) => [name, line[at]]))).filter((row) => row.role === "check");
  const errors = rows.map((row) => ["east_m", "north_m", "height_m"].map((axis, at) => Number(row[axis]) - truth.marks[row.point].map[at]));
  const sigmas = rows.map((row) => ["sigma_east_m", "sigma_north_m", "sigma_height_m"].map((axis) => Number(row[axis])));
  const of = (list) => [0, 1, 2].map((axis) => `${(1000 * rms(list.map((one) => one[axis]))).toFixed(1)}`).join(" ");
  return `check points (${rows.length}): true errors E N H ${of(errors)} mm RMS, their standard deviations ${of(sigmas)} mm`;
}

makeProjects();
const truth = truthOf(survey);
await mark(truth);
run("adjust", marked);
for (const [name, project] of [["by the page", marked], ["by the file of the survey", given]]) console.log(`${name}: ${judged(project, truth)}`);
process.exit(0);
