#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// Ten control points marked in six photographs each, in the page of a server of a rendered survey whose truth is known: events of a person, how far
// off predicted positions are, how far off marks lie, what a refinement costs, and check points beside those of the control file of the survey.
//
// usage: node bench/control_marking.mjs PROGRAM FOLDER
//
// FOLDER is made, and may hold nothing before.
import { execFileSync } from "node:child_process";
import { cpSync, existsSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { performance } from "node:perf_hooks";
import { fileURLToPath } from "node:url";

const web = join(dirname(fileURLToPath(import.meta.url)), "..", "web");
const { chromium } = createRequire(join(web, "package.json"))("playwright-core");
const { serve, startBrowser } = await import(join(web, "test", "station.mjs"));
const { screenOf, shown, until } = await import(join(web, "test", "control_tests.mjs"));
const { countRequests, quiet } = await import(join(web, "test", "quiet.mjs"));
const { truthOf } = await import(join(web, "test", "truth.mjs"));
const [program, folder] = process.argv.slice(2).map((path) => resolve(path));
if (!program || !folder) throw new Error("usage: node bench/control_marking.mjs PROGRAM FOLDER");
if (existsSync(folder) && readdirSync(folder).length) throw new Error(`${folder} is not empty: name a folder that can be made`);
const [survey, marked, given] = ["survey", "marked", "given"].map((name) => join(folder, name));
const enough = 6; // marks of a point
const wanted = 10; // points
const glance_px = 5; // a person sees that the cross is not on the target
const hand_px = 2; // how well a person points, of the photograph

let seed = 11;
const uniform = () => (seed = (seed * 1103515245 + 12345) % 2147483648) / 2147483648;
const normal = () => Math.sqrt(-2 * Math.log(uniform() || 1e-9)) * Math.cos(2 * Math.PI * uniform());
const run = (...args) => execFileSync(program, [...args, "--progress", "none"], { encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
const rms = (values) => Math.sqrt(values.reduce((sum, one) => sum + one * one, 0) / values.length);
const apart = (a, b) => Math.hypot(...a.map((value, axis) => value - b[axis]));
const quantile = (values, share) => [...values].sort((a, b) => a - b)[Math.min(Math.floor(share * values.length), values.length - 1)];

/** The survey with ten control points that enough photographs show, and two projects of it: control marked nowhere, and marked by the survey. Check points are marked in both. */
function makeProjects() {
  mkdirSync(folder, { recursive: true });
  run("simulate", survey, "--strips", "4", "--images-per-strip", "8", "--forward-overlap", "0.85", "--side-overlap", "0.75", "--cross-strips", "0",
    "--width-px", "1024", "--height-px", "768", "--gsd-m", "0.06", "--control-points", "16", "--check-points", "8");
  const lines = readFileSync(join(survey, "control.csv"), "utf8").split("\n");
  const isOf = (name) => (line) => new RegExp(`^(image|point), ${name},`).test(line);
  const names = lines.flatMap((line) => /^point, (C\d+),/.exec(line)?.[1] ?? []);
  const kept = names.filter((name) => lines.filter(isOf(name)).length > enough).slice(0, wanted);
  if (kept.length < wanted) throw new Error(`only ${kept.length} control points are shown by ${enough} photographs`);
  const control = lines.filter((line) => !names.some((name) => isOf(name)(line)) || kept.some((name) => isOf(name)(line)));
  writeFileSync(join(survey, "marked.csv"), control.join("\n"));
  writeFileSync(join(survey, "points.csv"), control.filter((line) => !/^image, C/.test(line)).join("\n"));
  run("run", join(survey, "images"), "-o", marked, "--control", join(survey, "points.csv"), "--until", "adjust");
  cpSync(marked, given, { recursive: true });
  run("run", join(survey, "images"), "-o", given, "--control", join(survey, "marked.csv"), "--until", "adjust");
}

async function mark(truth) {
  const server = await serve(program, marked);
  const browser = await startBrowser(chromium);
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, locale: "en-GB" });
  countRequests(context);
  const page = await context.newPage();
  await page.goto(server.link);
  await page.waitForURL(/#\/[^/]+\//);
  const project = `${server.base}/api/projects/${page.url().split("#/")[1].split("/")[0]}`;
  const get = async (what) => await (await page.request.get(`${project}/${what}`)).json();
  const marksOf = async (name) => (await get("control")).points.find((one) => one.name === name).marks;
  await page.goto(`${page.url().split("#")[0]}#/${project.split("/").at(-1)}/control`);
  await page.getByRole("application").waitFor();

  let events = 0;
  const predictions = []; // how far off they are, of the third mark of a point and later ones [px]
  const passed = new Set(); // points and photographs that were gone by
  const used = { predicted: 0, pointed: 0, skipped: 0 };
  const press = (key) => (++events, page.keyboard.press(key));
  /** Whether a target is found where the key looks for it, and marked. */
  const measured = async (key) => {
    const answered = page.waitForResponse((one) => one.url().endsWith("/refine"));
    await press(key);
    if (!(await answered).ok()) return false;
    await page.waitForResponse((one) => one.url().endsWith("/edits") && one.request().method() === "POST").catch(() => {});
    return true;
  };
  const points = (await get("control")).points.filter((one) => one.role === "control").map((one) => one.name);
  for (const point of points)
    for (let before = await marksOf(point); before.length < enough; before = await marksOf(point)) {
      await until(page, async () => (await shown(page))[0] === point);
      await quiet(page); // positions by the mark before are shown
      const [, file] = await shown(page);
      const target = truth.pixelOfWorld(file, truth.marks[point].world);
      const place = (await get(`control/${encodeURIComponent(point)}/places`)).places.find((one) => one.file.endsWith(file));
      const off = target && place ? apart(place.pixel, target) : Infinity; // by the marks since, the photograph may not show it
      if (target && before.length >= 2) predictions.push(off);
      const isLast = before.length + 1 === enough && point === points.at(-1);
      const isNext = async () => {
        const [name, next] = await shown(page);
        return name !== point || next !== file || isLast;
      };
      if (target && off < glance_px && (await measured("Enter"))) ++used.predicted;
      else {
        const [x, y] = target ? await screenOf(page, target.map((value) => value + hand_px * normal())) : [];
        if (target) ++events; // the pointer is moved
        if (target) await page.mouse.move(x, y);
        const isMarked = target && (await measured("Space"));
        ++used[isMarked ? "pointed" : "skipped"];
        if (!isMarked && passed.has(`${point} ${file}`)) throw new Error(`${point} cannot be marked in ${enough} photographs: ${file} comes again`);
        passed.add(`${point} ${file}`);
        await press(isMarked ? "Enter" : "n");
      }
      await until(page, isNext);
    }
  console.log(`${points.length} points by ${events} events: ${used.predicted} marks by one key, ${used.pointed} pointed at (three events), ${used.skipped} photographs gone by`);
  const near = predictions.filter((off) => off <= 10).length;
  console.log(`predicted positions from the third mark on: ${near} of ${predictions.length} within 10 px, median ${quantile(predictions, 0.5).toFixed(2)} px, farthest ${Math.max(...predictions).toFixed(2)} px`);

  const control = (await get("control")).points.filter(({ role }) => role === "control");
  const marks = control.flatMap((one) => one.marks.map((made) => ({ ...made, truth: truth.pixelOfWorld(made.file.split("/").at(-1), truth.marks[one.name].world) })));
  const misses = marks.map((one) => apart(one.pixel, one.truth));
  console.log(`${marks.length} marks: ${rms(misses).toFixed(3)} px RMS of the distance, farthest ${Math.max(...misses).toFixed(3)} px, ${misses.filter((one) => one <= 0.1).length} within 0.1 px; errors ${rms(marks.map((one, i) => misses[i] / Math.SQRT2 / one.sigma_px)).toFixed(2)} times what is stated`);
  await refinements(page, project, server.pid, marks);
  await browser.close();
  await server.end();
}

/** What refinements cost that are asked one after the other, as the page asks them. */
async function refinements(page, project, pid, marks) {
  const processor_ms = () => {
    const words = readFileSync(`/proc/${pid}/stat`, "utf8").split(")").at(-1).trim().split(" ");
    return 10 * (Number(words[11]) + Number(words[12])); // ticks of 10 ms
  };
  await quiet(page, 3000); // the adjustment of the whole block is over
  const before = processor_ms();
  const clock_ms = [];
  for (const one of marks) {
    const began = performance.now();
    await page.request.post(`${project}/refine`, { data: { image: one.image, pixel: one.truth.map((value) => value + hand_px * normal()), kind: "auto" } });
    clock_ms.push(performance.now() - began);
  }
  const mean = (processor_ms() - before) / marks.length;
  console.log(`a refinement: clock median ${quantile(clock_ms, 0.5).toFixed(0)} ms, 95 of 100 within ${quantile(clock_ms, 0.95).toFixed(0)} ms, longest ${Math.max(...clock_ms).toFixed(0)} ms; processor ${mean.toFixed(1)} ms in the mean`);
}

makeProjects();
await mark(truthOf(survey));
run("adjust", marked);
for (const [name, project] of [["by the page", marked], ["by the file of the survey", given]])
  console.log(`${name}:\n${run("assess", project, join(survey, "truth")).split("\n").filter((line) => /points|centres/i.test(line)).join("\n")}`);
process.exit(0);
