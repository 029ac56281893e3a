#!/usr/bin/env node
// SPDX-License-Identifier: Apache-2.0
// How the page of `collinea serve` does with what is large, in a browser without a GPU: time to the first points of a cloud and to the first view of an
// orthophoto, bytes fetched, memory, tasks that keep the page's thread busy; and time until a project of many photographs can be used.
//
// usage: node bench/page_big.mjs PROGRAM BIG [MANY]
//   BIG   a project with products/cloud.copc.laz and products/ortho.tif (bench/big_products.py)
//   MANY  a project of 500 images: collinea simulate MANY --images 500 --observations-only; collinea orient MANY; collinea adjust MANY
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const web = join(dirname(fileURLToPath(import.meta.url)), "..", "web");
const { chromium } = createRequire(join(web, "package.json"))("playwright-core");
const { serve, startBrowser } = await import(join(web, "test", "station.mjs"));
const [program, big, many] = process.argv.slice(2);

/** A page of a server that has just begun: nothing is kept by the browser. */
async function opened(project) {
  const server = await serve(program, project);
  const browser = await startBrowser(chromium);
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, locale: "en-GB" });
  const fetched = new Map();
  const foreign = new Set();
  context.on("request", (request) => {
    if (new URL(request.url()).origin !== server.base) foreign.add(request.url());
  });
  context.on("response", (response) => {
    const path = new URL(response.url()).pathname;
    const name = path.split("/").at(-1);
    if (response.request().method() === "GET") fetched.set(name, (fetched.get(name) ?? 0) + Number(response.headers()["content-length"] ?? 0));
  });
  await context.addInitScript(() => {
    globalThis.tasks = [];
    new PerformanceObserver((list) => globalThis.tasks.push(...list.getEntries().map((one) => [Math.round(one.startTime), Math.round(one.duration)]))).observe({ entryTypes: ["longtask"] });
  });
  const page = await context.newPage();
  const end = async () => {
    await browser.close();
    await server.end();
  };
  return { server, browser, page, fetched, foreign, end };
}

const view = (page, name) => page.getByRole("navigation", { name: "Views" }).getByRole("link", { name, exact: true });
/** Waits in the page, frame by frame, and says after how many milliseconds from `since` (of the page's clock). */
const until = (page, since, holds) =>
  page.evaluate(
    ([since, holds]) =>
      new Promise((resolve) => {
        const test = new Function(`return (${holds})();`); // the page's own policy does not bind what a debugger evaluates
        const look = () => (test() ? resolve(performance.now() - since) : requestAnimationFrame(look));
        look();
      }),
    [since, holds.toString()],
  );
const clickAt = (page, name) =>
  page.evaluate((name) => {
    const link = [...document.querySelectorAll("nav a")].find((one) => one.textContent.trim() === name);
    const now = performance.now();
    link.click();
    return now;
  }, name);

/** Of the renderer of the page, its worker included: what it keeps to itself [MB]. */
async function residentMb(browser) {
  const session = await browser.newBrowserCDPSession();
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  const sizes = processInfo.filter((one) => one.type === "renderer").map((one) => {
    const status = readFileSync(`/proc/${one.id}/status`, "utf8");
    return Number(/RssAnon:\s+(\d+)/.exec(status)?.[1] ?? 0) / 1024;
  });
  return Math.max(...sizes);
}

async function cloud() {
  const { server, browser, page, fetched, end } = await opened(big);
  await page.goto(server.link);
  await view(page, "Scene").waitFor();
  await page.waitForTimeout(1000);
  const since = await clickAt(page, "Scene");
  const first = await until(page, since, () => /^\s*[1-9][\d,]* of/.test(document.querySelector(".scene .readout .state")?.textContent ?? ""));
  const bytes = fetched.get("cloud.copc.laz");
  console.log(`cloud: first points after ${(first / 1000).toFixed(2)} s, ${(bytes / 1e6).toFixed(1)} MB of it fetched by then`);
  const all = await until(page, since, () => document.querySelector('.scene [role="application"]')?.getAttribute("aria-busy") === "false");
  console.log(`cloud: all points of the view after ${(all / 1000).toFixed(1)} s: ${await page.locator(".scene .readout .state").innerText()}`);
  const box = await page.getByRole("application").boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(...middle);
  for (let i = 0; i < 12; ++i) {
    await page.mouse.wheel(0, -250);
    await page.waitForTimeout(250);
  }
  await page.mouse.down();
  for (let i = 0; i < 20; ++i) {
    await page.mouse.move(middle[0] + 15 * i, middle[1] + 4 * i);
    await page.waitForTimeout(100);
  }
  await page.mouse.up();
  await page.getByRole("button", { name: "Top" }).click();
  await page.getByRole("button", { name: "Show all" }).click();
  await page.waitForTimeout(5000);
  const heap = await page.evaluate(() => performance.memory.usedJSHeapSize / 1e6);
  const tasks = (await page.evaluate(() => globalThis.tasks)).filter(([start]) => start >= since);
  console.log(`cloud: after moving about ${((fetched.get("cloud.copc.laz") ?? 0) / 1e6).toFixed(0)} MB fetched; JS heap of the page ${heap.toFixed(0)} MB, renderer with its worker ${(await residentMb(browser)).toFixed(0)} MB resident`);
  const listed = tasks.sort((a, b) => b[1] - a[1]).slice(0, 10).map(([start, duration]) => `${duration} at ${((start - since) / 1000).toFixed(1)} s`);
  console.log(`cloud: longest task ${Math.max(0, ...tasks.map((one) => one[1]))} ms (${tasks.length} above 50 ms: ${listed.join(", ")})`);
  await end();
}

async function ortho() {
  const { server, page, fetched, end } = await opened(big);
  await page.goto(server.link);
  await view(page, "Map").waitFor();
  await page.waitForTimeout(1000);
  const since = await clickAt(page, "Map");
  const first = await until(page, since, () =>
    [...document.querySelectorAll(".target canvas")].some((canvas) => {
      const small = new OffscreenCanvas(16, 16).getContext("2d");
      small.drawImage(canvas, 0, 0, 16, 16);
      const data = small.getImageData(4, 4, 8, 8).data;
      return new Set(Array.from({ length: 64 }, (_, i) => (data[4 * i] << 16) | (data[4 * i + 1] << 8) | data[4 * i + 2])).size > 20;
    }),
  );
  console.log(`orthophoto: first view after ${(first / 1000).toFixed(2)} s, ${((fetched.get("ortho.tif") ?? 0) / 1e6).toFixed(2)} MB of it fetched`);
  await page.waitForTimeout(3000);
  console.log(`orthophoto: 3 s later ${((fetched.get("ortho.tif") ?? 0) / 1e6).toFixed(2)} MB`);
  await end();
}

async function start() {
  const { server, page, foreign, end } = await opened(many);
  await page.goto(server.link, { waitUntil: "commit" });
  await page.waitForURL(/\/#\//, { waitUntil: "commit" }); // times are counted from here: the link has become the page
  for (const [name, ready] of [
    ["Project", () => document.querySelectorAll("tbody tr").length > 5],
    ["Photographs", () => document.querySelectorAll(".list li").length >= 500],
    ["Map", () => document.querySelectorAll(".target canvas").length > 0],
    ["Control", () => document.querySelector("main h2") !== null],
    ["Scene", () => document.querySelector(".scene canvas") !== null],
  ]) {
    const since = name === "Project" ? 0 : await clickAt(page, name);
    const after = await until(page, since, ready);
    const idle = await page.evaluate((since) => new Promise((resolve) => setTimeout(() => resolve(performance.now() - since), 0)), since);
    console.log(`start: ${name} can be used after ${(Math.max(after, idle) / 1000).toFixed(2)} s`);
    await page.waitForTimeout(1500);
  }
  console.log(`start: ${foreign.size} requests beyond this server${foreign.size ? `: ${[...foreign].join(", ")}` : ""}`);
  await end();
}

await cloud();
if (!process.env.ONLY_CLOUD) await ortho();
if (many) await start();
process.exit(0);
