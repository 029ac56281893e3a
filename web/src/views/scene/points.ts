// SPDX-License-Identifier: Apache-2.0
// The points of the cloud: the nodes that a view wants are loaded by the worker, kept within a budget, and drawn.
import { BufferAttribute, BufferGeometry, Frustum, Group, Matrix4, Points, Sphere, Vector3, type Camera, type RawShaderMaterial, type Texture } from "three";

import { Failures } from "../../lib/failures";
import type { CloudRegion } from "../../lib/types";
import type { CloudHeader, CloudNode } from "./cloud_file";
import { type FromWorker, type LoadedNode, type PickRay, type PickedPoint, type PlacedPoint, type Spread, type ToWorker } from "./messages";
import { LeastRecentlyUsed, wantedNodes } from "./octree";
import { pointMaterial } from "./shaders";
import type { Triple } from "./viewpoint";

/** So many points stay loaded for one that is drawn at most. */
const kept = 1.5;

export interface PointsEvents {
  opened(header: CloudHeader): void;
  /** Empty: what had failed is there now. */
  failed(why: string): void;
  /** The points are to be drawn anew. */
  changed(): void;
  /** There are more of them. */
  came(): void;
  spread(spread: Spread): void;
  /** A class was seen for the first time. */
  classes(classes: number[]): void;
}

export class CloudPoints {
  readonly group = new Group();
  readonly material: RawShaderMaterial = pointMaterial();
  budget = 2e6;
  header: CloudHeader | undefined;
  origin: Triple = [0, 0, 0];
  /** Points drawn of this view, those of the last frame, and nodes on their way. */
  drawn = 0;
  drawnNow = 0;
  loading = 0;
  readonly #worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
  readonly #events: PointsEvents;
  #used = new LeastRecentlyUsed();
  readonly #shown = new Map<number, Points<BufferGeometry, RawShaderMaterial>>();
  readonly #asked = new Set<number>();
  /** Nodes that are drawn of this view. */
  readonly #painted = new Set<number>();
  readonly #failures = new Failures<number>();
  readonly #waits = new Map<number, (point: PickedPoint | PlacedPoint | null) => void>();
  readonly #classes = new Set<number>();
  #nodes: CloudNode[] = [];
  #wanted: number[] = [];
  #ask = 0;
  /** Regions that the worker has not applied yet. */
  #applying = 0;
  /** The cloud that is being opened; empty: none. */
  #opening = "";

  constructor(events: PointsEvents) {
    this.#events = events;
    this.#worker.onmessage = (event: MessageEvent<FromWorker>) => this.#heard(event.data);
    this.#worker.onerror = (event) => this.#broke(event.message);
  }

  /** Something is on its way that changes what is drawn. */
  get isBusy(): boolean {
    return this.#opening !== "" || this.#asked.size > 0 || this.#applying > 0;
  }

  /** Another cloud in the place of the one before it. */
  open(address: string, regions: CloudRegion[]): void {
    this.#clear();
    this.#opening = address;
    this.#say({ open: address, regions });
    this.#events.changed();
  }

  setRegions(regions: CloudRegion[]): void {
    ++this.#applying;
    this.#say({ regions });
    this.#events.changed();
  }

  /** Chooses what a view shows; `pixels(node)`: size of its side on the screen. */
  update(camera: Camera, pixels: (node: CloudNode) => number): void {
    const frustum = new Frustum().setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
    const sphere = new Sphere();
    const seen = (node: CloudNode): number => {
      sphere.set(this.#local(node.centre), node.half * Math.sqrt(3));
      return frustum.intersectsSphere(sphere) ? pixels(node) : 0;
    };
    const now = performance.now();
    this.#wanted = wantedNodes(this.#nodes, seen, this.budget);
    const wanted = new Set(this.#wanted);
    const cancelled = [...this.#asked].filter((index) => !wanted.has(index));
    for (const index of cancelled) this.#asked.delete(index);
    if (cancelled.length) this.#say({ cancel: cancelled });
    for (const index of this.#wanted) {
      if (this.#shown.has(index)) this.#used.use(index, (this.#nodes[index] as CloudNode).points);
      else if (!this.#asked.has(index) && !this.#failures.isOff(index, now)) {
        this.#asked.add(index);
        this.#say({ load: index });
      }
    }
    this.loading = this.#asked.size;
    const evicted = this.#used.evicted(kept * this.budget, wanted);
    for (const index of evicted) this.#forget(index);
    if (evicted.length) this.#say({ drop: evicted });
  }

  /** Makes visible what is not drawn yet of the view, or of a new one, the most wanted first: about `most` points. Whether some are left. */
  paint(most: number, isAnew: boolean): boolean {
    if (isAnew) {
      this.#painted.clear();
      this.drawn = 0;
    }
    this.drawnNow = 0;
    for (const points of this.#shown.values()) points.visible = false;
    for (const index of this.#wanted) {
      const points = this.#shown.get(index);
      if (!points || this.#painted.has(index)) continue;
      if (this.drawnNow >= most) return true;
      points.visible = true;
      this.#painted.add(index);
      const count = (this.#nodes[index] as CloudNode).points;
      this.drawnNow += count;
      this.drawn += count;
    }
    return false;
  }

  /** The point under a ray, of those that are drawn. */
  pick(ray: PickRay): Promise<PickedPoint | null> {
    return this.#answer((ask, among) => ({ pick: ray, among, ask }));
  }

  /** The place that a ray means, of someone who points as well as `pointing_m`. */
  place(ray: PickRay, pointing_m: number): Promise<PlacedPoint | null> {
    return this.#answer((ask, among) => ({ pick: ray, among, ask, pointing_m })) as Promise<PlacedPoint | null>;
  }

  #answer(message: (ask: number, among: number[]) => ToWorker): Promise<PickedPoint | PlacedPoint | null> {
    const ask = ++this.#ask;
    return new Promise((resolve) => {
      this.#waits.set(ask, resolve);
      this.#say(message(ask, this.#wanted.filter((index) => this.#shown.has(index))));
    });
  }

  dispose(): void {
    this.#worker.terminate();
    this.#clear();
    for (const name of ["ramp", "classes"]) (this.material.uniforms[name]?.value as Texture).dispose();
    this.material.dispose();
    this.#answerNobody();
  }

  #answerNobody(): void {
    for (const resolve of this.#waits.values()) resolve(null);
    this.#waits.clear();
  }

  /** The worker ended or stumbled: nothing that it was asked for is waited for any longer. */
  #broke(why: string): void {
    [this.#opening, this.#applying] = ["", 0];
    this.#answerNobody();
    for (const index of [...this.#asked]) this.#missed(index, why);
    this.#events.failed(why);
    this.#events.changed();
  }

  #clear(): void {
    for (const index of [...this.#shown.keys()]) this.#forget(index);
    this.#used = new LeastRecentlyUsed();
    for (const one of [this.#asked, this.#failures, this.#classes]) one.clear();
    [this.header, this.#nodes, this.#wanted] = [undefined, [], []];
  }

  #say(message: ToWorker): void {
    this.#worker.postMessage(message);
  }

  #local(place: Triple): Vector3 {
    return new Vector3(place[0] - this.origin[0], place[1] - this.origin[1], place[2] - this.origin[2]);
  }

  #heard(message: FromWorker): void {
    if ("opened" in message) {
      if (message.address !== this.#opening) return;
      this.#clear();
      [this.header, this.#nodes, this.#opening] = [message.opened, message.nodes, ""];
      this.#events.opened(message.opened);
    } else if ("failed" in message) {
      if (message.address !== this.#opening) return;
      this.#opening = "";
      this.#events.failed(message.failed);
      this.#events.changed();
    } else if ("picked" in message) {
      this.#waits.get(message.ask)?.(message.picked);
      this.#waits.delete(message.ask);
    } else if ("applied" in message) {
      this.#applying = Math.max(this.#applying - 1, 0);
      this.#events.changed();
    } else if (!this.header) return; // of the cloud before this one
    else if ("loaded" in message) this.#take(message.loaded);
    else if ("missed" in message) this.#missed(message.missed, message.why);
    else this.#repaint(message.edited, message.colours, message.traits);
  }

  #missed(index: number, why: string): void {
    this.#asked.delete(index);
    const wait_ms = this.#failures.failed(index, performance.now());
    if (wait_ms !== undefined) setTimeout(() => this.#events.changed(), wait_ms);
    this.#events.failed(why);
    this.#events.changed();
  }

  #take(loaded: LoadedNode): void {
    const node = this.#nodes[loaded.node] as CloudNode;
    this.#asked.delete(loaded.node);
    this.#forget(loaded.node); // cancelled and asked for again, it may come twice
    if (this.#failures.size) {
      this.#failures.succeeded(loaded.node);
      if (!this.#failures.size) this.#events.failed("");
    }
    const geometry = new BufferGeometry();
    const positions = new BufferAttribute(loaded.positions, 3);
    positions.onUpload(function (this: BufferAttribute) {
      this.array = new Float32Array(0); // the worker has the exact ones
    });
    geometry.setAttribute("position", positions);
    geometry.setAttribute("colour", new BufferAttribute(loaded.colours, 4, true));
    geometry.setAttribute("traits", new BufferAttribute(loaded.traits, 4, true));
    geometry.setDrawRange(0, node.points);
    geometry.boundingSphere = new Sphere(new Vector3(), node.half * Math.sqrt(3));
    const points = new Points(geometry, this.material);
    points.frustumCulled = false;
    points.position.copy(this.#local(node.centre));
    this.#shown.set(loaded.node, points);
    this.group.add(points);
    this.#used.use(loaded.node, node.points);
    this.#note(loaded.colours, loaded.traits);
    if (loaded.spread) this.#events.spread(loaded.spread);
    this.#events.came();
  }

  /** Classes of the points that are left. */
  #note(colours: Uint8Array, traits: Uint8Array): void {
    const before = this.#classes.size;
    for (let i = 0; i < traits.length; i += 4) if (colours[i + 3]) this.#classes.add(traits[i] as number);
    if (this.#classes.size > before) this.#events.classes([...this.#classes].sort((a, b) => a - b));
  }

  #repaint(index: number, colours: Uint8Array, traits: Uint8Array): void {
    const geometry = this.#shown.get(index)?.geometry;
    this.#note(colours, traits);
    if (!geometry) return;
    for (const [name, values] of [["colour", colours], ["traits", traits]] as const) {
      const attribute = geometry.getAttribute(name) as BufferAttribute;
      (attribute.array as Uint8Array).set(values);
      attribute.needsUpdate = true;
    }
    this.#events.changed();
  }

  #forget(index: number): void {
    const points = this.#shown.get(index);
    if (!points) return;
    this.group.remove(points);
    points.geometry.dispose();
    this.#shown.delete(index);
    this.#painted.delete(index);
  }
}
