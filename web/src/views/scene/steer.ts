// SPDX-License-Identifier: Apache-2.0
// The scene by mouse, pen, fingers and keys.
import type { Stage } from "./stage.svelte";
import { sum, type Triple } from "./viewpoint";

const turnStep = Math.PI / 36;
const panStep = 0.1; // of the view's height
const clickPixels = 4; // that a hand may shake

export const standardViews = { top: [0, 0], front: [0, Math.PI / 2], side: [-Math.PI / 2, Math.PI / 2] } as const;
export type StandardView = keyof typeof standardViews;

export function lookFrom(stage: Stage, name: StandardView): void {
  stage.moved();
  const [heading, tilt] = standardViews[name];
  stage.view.look(heading, tilt);
  stage.redraw();
}

const moves: Record<string, (stage: Stage) => void> = {
  ArrowLeft: ({ view }) => view.turn(-turnStep, 0),
  ArrowRight: ({ view }) => view.turn(turnStep, 0),
  ArrowUp: ({ view }) => view.turn(0, -turnStep),
  ArrowDown: ({ view }) => view.turn(0, turnStep),
  w: ({ view }) => view.pan(0, panStep),
  a: ({ view }) => view.pan(-panStep, 0),
  s: ({ view }) => view.pan(0, -panStep),
  d: ({ view }) => view.pan(panStep, 0),
  "+": ({ view }) => view.zoom(1 / 1.3),
  "=": ({ view }) => view.zoom(1 / 1.3),
  "-": ({ view }) => view.zoom(1.3),
  "0": (stage) => stage.fitAll(),
  f: (stage) => stage.fitAll(),
  "1": (stage) => lookFrom(stage, "top"),
  "2": (stage) => lookFrom(stage, "front"),
  "3": (stage) => lookFrom(stage, "side"),
  "5": (stage) => stage.setParallel(!stage.isParallel),
};

/** Whether it was a key that moves the view. */
export function steerByKey(stage: Stage, event: KeyboardEvent): boolean {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const move = Object.hasOwn(moves, key) ? moves[key] : undefined;
  if (!move || event.ctrlKey || event.metaKey || event.altKey) return false;
  stage.moved();
  move(stage);
  stage.redraw();
  return true;
}

/** `clicked`: at pixels of the canvas. */
export function steer(stage: Stage, element: HTMLElement, clicked: (x: number, y: number) => void): () => void {
  const abort = new AbortController();
  const { signal } = abort;
  const fingers = new Map<number, [number, number]>();
  let [begun, last, isDrag, isPan] = [[0, 0] as [number, number], [0, 0] as [number, number], false, false];
  let [isPicking, waits] = [false, undefined as [number, number] | undefined];
  let hovered: { at: [number, number]; place: Triple } | undefined;

  const at = (event: MouseEvent): [number, number] => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  /** The point under the pointer; asked for again only when the answer is there. */
  const hover = async (place: [number, number]): Promise<void> => {
    waits = place;
    if (isPicking) return;
    isPicking = true;
    for (let next = waits as [number, number] | undefined; next; next = waits) {
      waits = undefined;
      const point = await stage.pick(...next);
      stage.under = point;
      hovered = point ? { at: next, place: sum(point.at, stage.origin, -1) } : undefined;
    }
    isPicking = false;
  };
  const anchor = (place: [number, number]): Triple =>
    hovered && Math.hypot(hovered.at[0] - place[0], hovered.at[1] - place[1]) < 12 ? hovered.place : stage.view.onPlane(stage.ray(...place));
  let held: Triple = [0, 0, 0];

  const panned = (to: [number, number]): void => {
    stage.view.target = sum(stage.view.target, sum(held, stage.view.onPlane(stage.ray(...to), held), -1));
  };
  const pinched = (id: number, to: [number, number]): void => {
    const other = [...fingers].find(([one]) => one !== id)?.[1];
    const before = fingers.get(id);
    if (!other || !before) return;
    const size = (from: [number, number]): number => Math.max(Math.hypot(from[0] - other[0], from[1] - other[1]), 10);
    stage.view.zoom(size(before) / size(to), held);
  };

  element.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, at(event));
    [begun, last, isDrag] = [at(event), at(event), fingers.size > 1];
    isPan = event.button !== 0 || event.shiftKey;
    held = anchor(begun);
    element.setPointerCapture(event.pointerId);
  }, { signal });
  element.addEventListener("pointermove", (event) => {
    const to = at(event);
    stage.pointer = to;
    if (!fingers.has(event.pointerId)) return void hover(to);
    if (Math.hypot(to[0] - begun[0], to[1] - begun[1]) > clickPixels) isDrag = true;
    if (!isDrag) return;
    stage.moved();
    if (fingers.size > 1) pinched(event.pointerId, to);
    else if (isPan) panned(to);
    else stage.view.turn((-Math.PI * (to[0] - last[0])) / stage.size[1], (-Math.PI * (to[1] - last[1])) / stage.size[1]);
    last = to;
    fingers.set(event.pointerId, to);
    stage.redraw();
  }, { signal });
  element.addEventListener("pointerleave", () => (stage.pointer = undefined), { signal });
  const up = (event: PointerEvent): void => {
    if (fingers.delete(event.pointerId) && !isDrag && event.type === "pointerup" && event.button === 0) clicked(...at(event));
  };
  element.addEventListener("pointerup", up, { signal });
  element.addEventListener("pointercancel", up, { signal });
  element.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1;
    const about = anchor(at(event));
    stage.moved();
    stage.view.zoom(Math.exp(Math.min(Math.max(event.deltaY * lines, -300), 300) * 0.0016), about);
    stage.redraw();
  }, { signal, passive: false });
  element.addEventListener("dblclick", (event) => {
    void stage.placeAt(...at(event)).then((place) => {
      stage.moved();
      stage.view.target = place;
      stage.redraw();
    });
  }, { signal });
  return () => abort.abort();
}
