// SPDX-License-Identifier: Apache-2.0
// Until a page has what it asked for and shows it, in place of waiting for some time.

const pending = new WeakMap(); // of a context: requests on their way, with when they began
const longest_ms = 2000; // what takes longer is not waited for: some never end, as those of a frame that was left

/** Counts the requests of a context from now on. */
export function countRequests(context) {
  const open = new Map();
  pending.set(context, open);
  context.on("request", (request) => open.set(request, Date.now()));
  for (const event of ["requestfinished", "requestfailed"]) context.on(event, (request) => open.delete(request));
}

/** Until what was done is drawn. */
export const drawn = (page) => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));

/** Until nothing is on its way for a moment, and all is drawn. */
export async function quiet(page, rest_ms = 100) {
  const open = pending.get(page.context());
  const isBusy = () => [...open.values()].some((began) => Date.now() - began < longest_ms);
  for (let since = Date.now(); Date.now() - since < rest_ms; await page.waitForTimeout(20)) if (isBusy()) since = Date.now();
  await drawn(page);
}
