// SPDX-License-Identifier: Apache-2.0
// The scene itself: what is drawn, from where, and what lies under the pointer.
import {
  BufferGeometry, Color, ColorManagement, DepthTexture, LinearSRGBColorSpace, Matrix4, Mesh, OrthographicCamera, PerspectiveCamera, PlaneGeometry, Points, Scene, Vector3, WebGLRenderTarget,
  WebGLRenderer,
} from "three";

import type { CloudRegion, ControlPoint, ImageInfo } from "../../lib/types";
import type { CloudHeader, CloudNode } from "./cloud_file";
import type { PickedPoint, PickRay, PlacedPoint, Spread } from "./messages";
import { Overlay, showControl } from "./overlays";
import { CloudPoints } from "./points";
import { type Pyramid, Pyramids, pyramidHeight, pyramidsOf } from "./pyramids";
import { type Colouring, colourings, shadingMaterial } from "./shaders";
import { dot, sum, type Triple, Viewpoint } from "./viewpoint";

ColorManagement.enabled = false;

/** A frame should take so long; it draws so many points at first, and at least and at most. */
const frameMs = 30;
const [firstSlice, leastSlice, mostSlice] = [1e4, 1e4, 4e6];
const pickPixels = 6; // how far from the pointer a point may lie
const pointingPixels = 1; // how well a person points: standard deviation of each coordinate

export class Stage {
  header = $state.raw<CloudHeader | undefined>();
  /** Everything is drawn about the first place of the map that is known: coordinates of the GPU are short. */
  origin = $state.raw<Triple>([0, 0, 0]);
  error = $state("");
  /** What most points lie between; nothing before the first are there. */
  spread = $state.raw<Spread | undefined>();
  /** Those seen so far. */
  classes = $state.raw<number[]>([]);
  drawn = $state(0);
  loading = $state(0);
  /** Under the pointer. */
  under = $state.raw<PickedPoint | undefined>();
  chosen = $state.raw<Pyramid | undefined>();
  /** Whose view is looked through. */
  through = $state.raw<Pyramid | undefined>();
  isParallel = $state(false);
  /** All that was asked for is loaded and drawn. */
  rests = $state(false);
  /** Where the pointer is on the canvas; nothing: elsewhere. */
  pointer: [number, number] | undefined;
  readonly view = new Viewpoint();
  readonly points: CloudPoints;
  readonly pyramids: Pyramids;
  readonly control = new Overlay(4);
  readonly drawing = new Overlay(5);
  readonly draft = new Overlay(6);
  isShaded = true;
  hasPictures = true;
  readonly #renderer: WebGLRenderer;
  /** Points are drawn into a target, some more in each frame; what lies over them is drawn on the screen. */
  readonly #pointScene = new Scene();
  readonly #scene = new Scene();
  readonly #perspective = new PerspectiveCamera();
  readonly #parallel = new OrthographicCamera();
  readonly #target: WebGLRenderTarget;
  readonly #shading;
  readonly #screen: Mesh<PlaneGeometry>;
  readonly #screenScene = new Scene();
  readonly #sizes: ResizeObserver;
  #frame = 0;
  /** Of the frame that the GPU is drawing, when it began, and when it was last known to be at work. */
  #fence: WebGLSync | undefined;
  #begun = 0;
  #atWork = 0;
  /** Points that a frame draws. */
  #slice = firstSlice;
  /** Those that are drawn are of another view. */
  #isAnew = true;
  #pixels = 1;
  #size: [number, number] = [1, 1];
  #radius = 100;
  #near = 1;
  #far = 1000;
  #hasOrigin = false;
  #isReady = false;
  #disposed = false;

  constructor(
    readonly canvas: HTMLCanvasElement,
    project: string,
  ) {
    this.#renderer = new WebGLRenderer({ canvas, powerPreference: "high-performance" });
    this.#renderer.debug.checkShaderErrors = false; // asking for them waits for the GPU
    this.#renderer.outputColorSpace = LinearSRGBColorSpace;
    const more = (): void => this.#ask();
    this.points = new CloudPoints({
      changed: () => this.redraw(),
      came: more,
      opened: (header) => this.#opened(header),
      failed: (why) => (this.error = why),
      spread: (spread) => (this.spread = spread),
      classes: (classes) => (this.classes = classes),
    });
    this.pyramids = new Pyramids(project, more);
    this.#target = new WebGLRenderTarget(1, 1, { depthTexture: new DepthTexture(1, 1) });
    this.#shading = shadingMaterial(this.#target.texture, this.#target.depthTexture as DepthTexture);
    this.#screen = new Mesh(new PlaneGeometry(2, 2), this.#shading);
    this.#screen.frustumCulled = false;
    this.#screenScene.add(this.#screen);
    this.#pointScene.add(this.points.group);
    this.#scene.add(this.pyramids.group, this.control.group, this.drawing.group, this.draft.group);
    void this.#compiled();
    this.#sizes = new ResizeObserver(() => this.#resize());
    this.#sizes.observe(canvas.parentElement ?? canvas);
    this.#resize();
  }

  /** Nothing is drawn before the GPU's programs are made: who draws earlier waits for them. */
  async #compiled(): Promise<void> {
    const sample = new Points(new BufferGeometry(), this.points.material);
    this.#pointScene.add(sample);
    await Promise.all([this.#pointScene, this.#scene, this.#screenScene].map((scene) => this.#renderer.compileAsync(scene, this.#perspective))).catch(() => {});
    this.#pointScene.remove(sample);
    this.#isReady = true;
    this.redraw();
  }

  get size(): [number, number] {
    return this.#size;
  }
  get #camera(): PerspectiveCamera | OrthographicCamera {
    return this.view.isParallel ? this.#parallel : this.#perspective;
  }

  /** Only the first one counts. */
  setOrigin(origin: Triple): void {
    if (!this.#hasOrigin) this.origin = this.points.origin = origin.map(Math.round) as Triple;
    this.#hasOrigin = true;
  }

  setBackground(colour: string): void {
    this.#renderer.setClearColor(new Color(colour), 1);
    this.redraw();
  }

  setImages(images: ImageInfo[]): void {
    this.pyramids.set(pyramidsOf(images, this.origin, pyramidHeight(images)));
    if (!this.points.header) this.fitAll();
    this.redraw();
  }

  setControl(points: ControlPoint[]): void {
    showControl(this.control, points, this.origin);
    this.redraw();
  }

  openCloud(address: string, regions: CloudRegion[]): void {
    this.error = "";
    this.points.open(address, regions);
  }

  setColouring(colouring: Colouring, range: [number, number]): void {
    const { uniforms } = this.points.material;
    uniforms["colouring"]!.value = colourings.indexOf(colouring);
    uniforms["range"]!.value.set(...range);
    this.redraw();
  }

  setPointSize(size: number): void {
    this.points.material.uniforms["size"]!.value = size * this.#pixels;
    this.redraw();
  }

  setParallel(isParallel: boolean): void {
    this.isParallel = this.view.isParallel = isParallel;
    this.redraw();
  }

  /** All that there is. */
  fitAll(): void {
    this.#leave();
    const header = this.points.header;
    const ends = header ? [header.lowest, header.highest].map((one) => sum(one, this.origin, -1)) : this.pyramids.pyramids.flatMap((one) => [one.apex, ...one.corners]);
    if (!ends.length) return;
    const [low, high] = [Math.min, Math.max].map((end) => [0, 1, 2].map((axis) => end(...ends.map((one) => one[axis] as number)))) as [Triple, Triple];
    this.#radius = Math.max(Math.hypot(...sum(high, low, -1)) / 2, 1);
    this.view.fit(low, high, this.#size[0] / this.#size[1]);
    this.redraw();
  }

  /** From the eye of a photograph, with its field of view. */
  lookThrough(pyramid: Pyramid): void {
    const forward = sum(pyramid.corners.reduce((mean, one) => sum(mean, one, 0.25), [0, 0, 0] as Triple), pyramid.apex, -1);
    const up = sum(pyramid.corners[0], pyramid.corners[3], -1);
    this.view.lookAlong(forward, up);
    this.view.isParallel = this.isParallel = false;
    this.view.distance = this.#heightAbove(pyramid.apex);
    this.view.target = sum(pyramid.apex, this.view.axes.forward, this.view.distance);
    this.view.fov = 2 * Math.atan(Math.hypot(...up) / 2 / Math.hypot(...forward));
    this.pyramids.cover(pyramid, this.view.distance / Math.hypot(...forward));
    this.through = pyramid;
    this.redraw();
  }

  redraw(): void {
    this.#isAnew = true;
    this.#ask();
  }

  /** A frame: what lies over the points anew, and points that are not drawn yet. */
  #ask(): void {
    this.rests = false;
    if (!this.#frame && !this.#disposed && this.#isReady) this.#frame = requestAnimationFrame(() => this.#next());
  }

  /** A frame only when the one before it is drawn, and of a part of the points: commands that wait for a slow GPU would hold up the page. */
  #next(): void {
    this.#frame = 0;
    const gl = this.#renderer.getContext() as WebGL2RenderingContext;
    const now = performance.now();
    if (this.#fence) {
      if (gl.getSyncParameter(this.#fence, gl.SYNC_STATUS) !== gl.SIGNALED && !gl.isContextLost()) {
        this.#atWork = now;
        return this.#ask();
      }
      if (now - this.#atWork < 2 * frameMs) this.#pace(now - this.#begun); // else nobody knows when it ended
      gl.deleteSync(this.#fence);
      this.#fence = undefined;
    }
    const isMore = this.#draw();
    this.#begun = this.#atWork = performance.now();
    this.#fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0) ?? undefined;
    gl.flush();
    if (isMore) this.#ask();
    else if (!this.#isBusy) this.#look();
  }

  /** More points than the last frame drew, or fewer, by the time that it took. */
  #pace(took_ms: number): void {
    if (took_ms < frameMs && this.points.drawnNow < this.#slice) return; // a full frame may take longer
    this.#slice = Math.min(Math.max(this.#slice * Math.min(Math.max(frameMs / took_ms, 0.5), 4), leastSlice), mostSlice);
  }

  /** Something that is to be drawn is on its way: who brings it asks for a frame. */
  get #isBusy(): boolean {
    return this.points.isBusy || (this.pyramids.group.visible && this.pyramids.isBusy);
  }

  /** Until the GPU has drawn the last frame. */
  #look(): void {
    requestAnimationFrame(() => {
      const gl = this.#renderer.getContext() as WebGL2RenderingContext;
      if (this.#frame || this.#disposed || this.rests || this.#isBusy) return;
      if (this.#fence && gl.getSyncParameter(this.#fence, gl.SYNC_STATUS) !== gl.SIGNALED && !gl.isContextLost()) return this.#look();
      this.rests = true;
    });
  }

  /** Moved by hand: a photograph is no longer looked through. */
  moved(): void {
    this.#leave();
    this.redraw();
  }

  /** Places of the view from -1 to 1, of pixels of the canvas. */
  #unit(x: number, y: number): [number, number] {
    return [(2 * x) / this.#size[0] - 1, 1 - (2 * y) / this.#size[1]];
  }

  ray(x: number, y: number): { origin: Triple; direction: Triple } {
    return this.view.ray(...this.#unit(x, y), this.#size[0] / this.#size[1]);
  }

  /** The view ray of a pixel, with how far from it points may lie. */
  #pickRay(x: number, y: number): PickRay {
    const { origin, direction } = this.ray(x, y);
    const slope = this.view.isParallel ? 0 : (pickPixels * this.#perPixel) / this.view.distance;
    return { origin: sum(origin, this.origin), direction, slope, radius_m: this.view.isParallel ? pickPixels * this.#perPixel : 0 };
  }
  /** Metres of a pixel at the target. */
  get #perPixel(): number {
    return (2 * this.view.halfHeight) / this.#size[1];
  }

  /** The point of the cloud at a pixel of the canvas. */
  async pick(x: number, y: number): Promise<PickedPoint | undefined> {
    return this.points.header ? ((await this.points.pick(this.#pickRay(x, y))) ?? undefined) : undefined;
  }

  /** The place that a click there means: on the surface of the points about it. */
  async place(x: number, y: number, point: PickedPoint): Promise<PlacedPoint | undefined> {
    const ray = this.#pickRay(x, y);
    const away = this.view.isParallel ? this.view.distance : dot(sum(point.at, ray.origin, -1), ray.direction);
    return (await this.points.place(ray, (pointingPixels * this.#perPixel * away) / this.view.distance)) ?? undefined;
  }

  /** What a pixel of the canvas shows; where no point lies the plane through the target. */
  async placeAt(x: number, y: number): Promise<Triple> {
    const point = await this.pick(x, y);
    return point ? sum(point.at, this.origin, -1) : this.view.onPlane(this.ray(x, y));
  }

  pyramidAt(x: number, y: number): Pyramid | undefined {
    return this.pyramids.group.visible ? this.pyramids.at(x, y, this.#camera, (place) => this.pixelOf(place)) : undefined;
  }

  /** Where a local place is on the canvas; nothing behind the eye. */
  pixelOf(place: Triple): [number, number] | undefined {
    const at = new Vector3(...place).project(this.#camera);
    return at.z < 1 && at.z > -1 ? [((at.x + 1) / 2) * this.#size[0], ((1 - at.y) / 2) * this.#size[1]] : undefined;
  }

  choose(pyramid: Pyramid | undefined): void {
    if (this.chosen === pyramid) return;
    this.chosen = pyramid;
    this.pyramids.choose(pyramid?.image.id);
    this.redraw();
  }

  dispose(): void {
    this.#disposed = true;
    cancelAnimationFrame(this.#frame);
    this.#sizes.disconnect();
    this.points.dispose();
    this.pyramids.dispose();
    for (const overlay of [this.control, this.drawing, this.draft]) overlay.clear();
    this.#target.dispose();
    this.#shading.dispose();
    this.#screen.geometry.dispose();
    this.#renderer.forceContextLoss(); // browsers keep few contexts, and let go of those of old pages late
    this.#renderer.dispose();
  }

  #leave(): void {
    if (!this.through) return;
    this.through = undefined;
    this.pyramids.cover(undefined);
    this.view.level();
  }

  #opened(header: CloudHeader): void {
    this.setOrigin(header.centre);
    const isFirst = !this.header;
    this.header = header;
    if (isFirst) this.fitAll();
    else this.redraw();
  }

  #heightAbove(place: Triple): number {
    const header = this.points.header;
    const ground = header ? (header.lowest[2] + header.highest[2]) / 2 - this.origin[2] : place[2] - this.#radius;
    return Math.max(place[2] - ground, this.#radius / 50);
  }

  #resize(): void {
    const box = (this.canvas.parentElement ?? this.canvas).getBoundingClientRect();
    this.#size = [Math.max(box.width, 1), Math.max(box.height, 1)];
    this.#pixels = Math.min(window.devicePixelRatio || 1, 2);
    this.#renderer.setPixelRatio(this.#pixels);
    this.#renderer.setSize(...this.#size);
    this.#target.setSize(Math.round(this.#size[0] * this.#pixels), Math.round(this.#size[1] * this.#pixels));
    this.redraw();
  }

  #pose(): void {
    const { right, up, forward } = this.view.axes;
    const [camera, eye] = [this.#camera, this.view.isParallel ? sum(this.view.target, this.view.axes.forward, -20 * this.view.distance - 2 * this.#radius) : this.view.eye];
    camera.position.set(...eye);
    camera.quaternion.setFromRotationMatrix(new Matrix4().makeBasis(new Vector3(...right), new Vector3(...up), new Vector3(...forward).negate()));
    const away = Math.hypot(...sum(this.view.target, eye, -1));
    const aspect = this.#size[0] / this.#size[1];
    this.#near = this.view.isParallel ? 0 : Math.max(0.02 * this.view.distance, 0.02);
    this.#far = away + 4 * this.#radius + 4 * this.view.distance;
    if (this.view.isParallel) {
      const half = this.view.halfHeight;
      [this.#parallel.left, this.#parallel.right, this.#parallel.top, this.#parallel.bottom] = [-half * aspect, half * aspect, half, -half];
    } else {
      this.#perspective.fov = (this.view.fov * 180) / Math.PI;
      this.#perspective.aspect = aspect;
    }
    [camera.near, camera.far] = [this.#near, this.#far];
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
  }

  #pixelsOf(half: number, centre: Triple): number {
    const perMetre = this.#size[1] / (2 * Math.tan(this.view.fov / 2));
    if (this.view.isParallel) return (2 * half * this.#size[1]) / (2 * this.view.halfHeight);
    const away = Math.hypot(...sum(centre, this.view.eye, -1)) - Math.sqrt(3) * half;
    return (2 * half * perMetre) / Math.max(away, this.#near);
  }

  /** Whether points are left for another frame. */
  #draw(): boolean {
    this.#pose();
    const camera = this.#camera;
    // Marks have their size on the screen: half a pixel for one of their pictures.
    const half = this.view.isParallel ? this.view.halfHeight : Math.tan(this.view.fov / 2);
    for (const overlay of [this.control, this.drawing, this.draft]) overlay.resize(half / this.#size[1]);
    this.points.update(camera, (node: CloudNode) => this.#pixelsOf(node.half, sum(node.centre, this.origin, -1)));
    const isMore = this.points.paint(this.#slice, this.#isAnew);
    if (this.pyramids.group.visible) this.pyramids.update((one) => this.#pyramidSize(one), this.hasPictures);
    [this.drawn, this.loading] = [this.points.drawn, this.points.loading];
    this.#renderer.autoClear = this.#isAnew;
    this.#isAnew = false;
    this.#renderer.setRenderTarget(this.#target);
    this.#renderer.render(this.#pointScene, camera);
    const { uniforms } = this.#shading;
    uniforms["pixel"]!.value.set(1 / this.#target.width, 1 / this.#target.height);
    uniforms["range"]!.value.set(this.#near, this.#far);
    uniforms["parallel"]!.value = this.view.isParallel;
    uniforms["shaded"]!.value = this.isShaded;
    this.#renderer.autoClear = true;
    this.#renderer.setRenderTarget(null);
    this.#renderer.render(this.#screenScene, camera);
    this.#renderer.autoClear = false;
    this.#renderer.render(this.#scene, camera);
    return isMore;
  }

  /** How large the base of a pyramid is on the screen [px]; 0: it is not in view. */
  #pyramidSize(one: Pyramid): number {
    const side = Math.hypot(...sum(one.corners[0], one.corners[2], -1));
    if (this.#pixelsOf(side / 2, one.corners[0]) < 1) return 0; // too far away to be worth more
    const base = one.corners.map((corner) => this.pixelOf(corner));
    const [a, b] = [base[0], base[2]];
    if (!a || !b) return 0;
    const isBeyond = ([0, 1] as const).some((axis) => base.every((at) => at && at[axis] < 0) || base.every((at) => at && at[axis] > this.#size[axis]));
    return isBeyond ? 0 : Math.hypot(a[0] - b[0], a[1] - b[1]);
  }
}
