// SPDX-License-Identifier: Apache-2.0
// Which keys belong to a view, and which to what has the focus.

let isByPointer = false;
if (typeof window !== "undefined") {
  window.addEventListener("pointerdown", () => (isByPointer = true), true);
  window.addEventListener("keydown", () => (isByPointer = false), true);
}

/** What was pressed or chosen with the pointer gives the focus back, so that keys do not press it again. */
export function passFocus(event: Event, to: HTMLElement | null | undefined): void {
  const used = event.target instanceof Element ? event.target.closest("button, select, input[type=checkbox], input[type=radio]") : null;
  const isChosen = event.type === "change" || used instanceof HTMLButtonElement;
  if (isByPointer && used && isChosen && !used.hasAttribute("aria-expanded")) to?.focus({ preventScroll: true });
}

const fields = "input:not([type=checkbox], [type=radio], [type=range], [type=button]), textarea, select, [contenteditable]";

/** Whether what has the focus wants this key for itself: letters go into fields, Enter and Space press buttons. */
export function isTaken(event: KeyboardEvent): boolean {
  const target = event.target;
  if (event.altKey || !(target instanceof Element)) return event.altKey;
  if (target.closest(fields)) return true;
  if (event.key === "Enter" || event.key === " ") return target.closest("button, a, summary, input") !== null;
  return event.key.startsWith("Arrow") && target.closest("input[type=range]") !== null;
}
