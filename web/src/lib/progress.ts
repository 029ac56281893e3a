// SPDX-License-Identifier: Apache-2.0
import type { Job, LogLine } from "./types";

const firstWord = (text: string): string => text.split(/[ :]/)[0] ?? "";

/** The step that a running job is at: its stage names it, or else it follows the last one that the log names; nothing when it is not known. */
export function stepInWork(job: Job | undefined, log: readonly LogLine[], steps: readonly string[]): string | undefined {
  if (job?.state !== "running") return undefined;
  const stage = firstWord(job.stage);
  if (steps.includes(stage)) return stage;
  for (let i = log.length - 1; i >= 0; --i) {
    const line = log[i] as LogLine;
    // "match    15 pairs verified": a step is over; "match: 4 of 15 pairs kept": it began.
    const step = firstWord(line.line);
    if (line.job !== job.id || !steps.includes(step)) continue;
    return line.line.startsWith(`${step}:`) ? step : steps[steps.indexOf(step) + 1];
  }
  return undefined;
}
