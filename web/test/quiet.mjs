// SPDX-License-Identifier: Apache-2.0
// Until a page has what it asked for and shows it, in place of waiting for some time.

const pending = new WeakMap(); // of a context: requests on their way, with when they began
const longest_ms = 30_000; // as Playwright waits for anything else

/** Counts the requests of a context from now on. */
export function countRequests(context) {
  const open = new Map();
  pending.set(context, open);
  context.on("request", (request) => {
    if (!request.url().endsWith("/icon.svg")) open.set(request, Date.now()); // of the tab: where answers are made up nobody hears that it came
  });
  for (const event of ["requestfinished", "requestfailed"]) context.on(event, (request) => open.delete(request));
}

/** Until what was done is drawn. */
export const drawn = (page) => page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve))));

/** Whether nobody waits for the answer: its frame was left, or its page closed. */
function isLeft(request) {
  try {
    return request.frame().isDetached() || request.frame().page().isClosed();
  } catch {
    return false; // a navigation that has no frame yet
  }
}

/** Until nothing is on its way for a moment, and all is drawn. A request that is not answered ends the test by its name. */
export async function quiet(page, rest_ms = 100) {
  const open = pending.get(page.context());
  const began = Date.now();
  for (let since = began; Date.now() - since < rest_ms; await page.waitForTimeout(20)) {
    const waiting = [...open].filter(([request]) => !isLeft(request));
    if (waiting.length) since = Date.now();
    if (Date.now() - began < longest_ms) continue;
    const named = waiting.map(([request, at]) => `${request.method()} ${request.url()} for ${((Date.now() - at) / 1000).toFixed(1)} s`);
    throw new Error(`the page does not come to rest; on their way: ${named.join(", ") || "nothing now"}`);
  }
  await drawn(page);
}
