// SPDX-License-Identifier: Apache-2.0
// Both photographs of a pair in epipolar geometry, resampled by the GPU, and what is drawn over them, in one of the displays.
import type { StereoPlace, StereoSide } from "../../lib/stereo_types";
import type { Vector2 } from "../../lib/types";
import type { Tiles } from "../../parts/photo/tiles";
import { Atlas } from "./atlas";
import { pixelAt } from "./geometry";
import { type Display, fragmentShader, vertexShader } from "./shaders";

/** What is shown: what of each epipolar image is in the middle, and how large. */
export interface Scene {
  left: Vector2;
  right: Vector2;
  /** Pixels of the screen for one of the epipolar images. */
  zoom: number;
  display: Display;
  swapped: boolean;
  contrast: number;
  brightness: number;
}

export type Paint = (context: CanvasRenderingContext2D | OffscreenCanvasRenderingContext2D, which: "left" | "right", width: number, height: number) => void;

const numbers: Record<Display, number> = { anaglyph: 0, anaglyph_colour: 1, parallel: 2, crossed: 2, interlaced: 3, flip: 4, left: 4 };
const nothing = -1e6;

interface Eye {
  name: "left" | "right";
  side: StereoSide;
  atlas: Atlas;
  lattice: WebGLTexture;
  over: WebGLTexture;
  sheet: OffscreenCanvas;
}

export class Renderer {
  readonly #gl: WebGL2RenderingContext;
  readonly #program: WebGLProgram;
  readonly #places = new Map<string, WebGLUniformLocation | null>();
  #eyes: Eye[] = [];

  /** Nothing where the browser has no WebGL 2. */
  static on(canvas: HTMLCanvasElement): Renderer | undefined {
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, powerPreference: "high-performance" });
    if (!gl) return undefined;
    try {
      return new Renderer(gl, canvas);
    } catch (error) {
      console.warn(error);
      return undefined;
    }
  }

  private constructor(
    gl: WebGL2RenderingContext,
    readonly canvas: HTMLCanvasElement,
  ) {
    this.#gl = gl;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertexShader], [gl.FRAGMENT_SHADER, fragmentShader]] as const) {
      const shader = gl.createShader(kind);
      if (!shader) throw new Error("no shader");
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader) ?? "shader");
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) ?? "program");
    this.#program = program;
  }

  /** Another pair. `again` is called when a tile has come. */
  hold(place: StereoPlace, tiles: Tiles, again: () => void): void {
    this.release();
    const gl = this.#gl;
    this.#eyes = (["left", "right"] as const).map((name) => ({
      name,
      side: place[name],
      atlas: new Atlas(gl, place[name], tiles, again),
      lattice: this.#latticeOf(place[name]),
      over: this.#plain(gl.LINEAR),
      sheet: new OffscreenCanvas(1, 1),
    }));
  }

  release(): void {
    for (const eye of this.#eyes) {
      eye.atlas.dispose();
      this.#gl.deleteTexture(eye.lattice);
      this.#gl.deleteTexture(eye.over);
    }
    this.#eyes = [];
  }

  /** The memory of the GPU is given back. */
  dispose(): void {
    this.release();
    this.#gl.getExtension("WEBGL_lose_context")?.loseContext();
  }

  get complete(): boolean {
    return this.#eyes.every((eye) => eye.atlas.complete);
  }

  /** How wide and high the picture of each eye is, in pixels of the screen. */
  viewport(display: Display): Vector2 {
    const { width, height } = this.canvas;
    return [display === "parallel" || display === "crossed" ? width / 2 : width, height];
  }

  /** `phase`: which eye, where they take turns. */
  draw(scene: Scene, paint: Paint, phase: number): void {
    const gl = this.#gl;
    if (this.#eyes.length === 0) return;
    const [width, height] = this.viewport(scene.display);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.useProgram(this.#program);
    this.#eyes.forEach((eye, k) => this.#setEye(eye, 4 * k, scene, paint, width, height));
    gl.uniform2f(this.#at("u_screen"), this.canvas.width, this.canvas.height);
    gl.uniform2f(this.#at("u_viewport"), width, height);
    gl.uniform1f(this.#at("u_per_screen"), 1 / scene.zoom);
    gl.uniform1f(this.#at("u_contrast"), scene.contrast);
    gl.uniform1f(this.#at("u_brightness"), scene.brightness);
    gl.uniform1i(this.#at("u_display"), numbers[scene.display]);
    const turned = (scene.display === "crossed") !== scene.swapped;
    gl.uniform1i(this.#at("u_phase"), scene.display === "flip" ? phase : turned ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  #setEye(eye: Eye, unit: number, scene: Scene, paint: Paint, width: number, height: number): void {
    const gl = this.#gl;
    // Anaglyphs give the left image to the left eye by its filter: swapped, the right one goes there.
    const isMixed = scene.display === "anaglyph" || scene.display === "anaglyph_colour";
    const slot = isMixed && scene.swapped ? (eye.name === "left" ? "right" : "left") : eye.name;
    const middle = scene[eye.name];
    const reach: Vector2 = [width / 2 / scene.zoom, height / 2 / scene.zoom];
    eye.atlas.show(this.#windowOf(eye.side, middle, reach), scene.zoom);
    this.#paintOver(eye, paint, width, height);
    const units: [string, number, WebGLTexture][] = [["lattice", gl.TEXTURE_2D, eye.lattice], ["tiles", gl.TEXTURE_2D_ARRAY, eye.atlas.texture], ["pages", gl.TEXTURE_2D, eye.atlas.pages], ["over", gl.TEXTURE_2D, eye.over]];
    units.forEach(([name, target, texture], k) => {
      gl.activeTexture(gl.TEXTURE0 + unit + k);
      gl.bindTexture(target, texture);
      gl.uniform1i(this.#at(`u_${slot}_${name}`), unit + k);
    });
    gl.activeTexture(gl.TEXTURE0 + 15);
    gl.uniform2f(this.#at(`u_${slot}_middle`), ...middle);
    gl.uniform2f(this.#at(`u_${slot}_size`), eye.side.width, eye.side.height);
    gl.uniform2i(this.#at(`u_${slot}_level`), ...eye.atlas.levelSize);
    gl.uniform1f(this.#at(`u_${slot}_reduction`), eye.atlas.reduction);
    gl.uniform1f(this.#at(`u_${slot}_step`), eye.side.lattice.step_px);
  }

  #paintOver(eye: Eye, paint: Paint, width: number, height: number): void {
    const gl = this.#gl;
    const size: Vector2 = [Math.max(1, Math.floor(width)), Math.max(1, Math.floor(height))];
    if (eye.sheet.width !== size[0] || eye.sheet.height !== size[1]) [eye.sheet.width, eye.sheet.height] = size;
    const context = eye.sheet.getContext("2d");
    if (!context) return;
    context.clearRect(0, 0, ...size);
    paint(context, eye.name, ...size);
    gl.activeTexture(gl.TEXTURE0 + 15);
    gl.bindTexture(gl.TEXTURE_2D, eye.over);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, eye.sheet);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
  }

  /** The pixels of the photograph that are in view: those of a grid of the view, and their surroundings. */
  #windowOf(side: StereoSide, middle: Vector2, reach: Vector2): [number, number, number, number] {
    const window: [number, number, number, number] = [Infinity, Infinity, -Infinity, -Infinity];
    const steps = 8;
    const clamped = (value: number, most: number): number => Math.min(Math.max(value, 0), most - 1e-6);
    for (let i = 0; i <= steps; ++i)
      for (let j = 0; j <= steps; ++j) {
        const x = clamped(middle[0] + reach[0] * ((2 * i) / steps - 1), side.columns);
        const y = clamped(middle[1] + reach[1] * ((2 * j) / steps - 1), side.rows);
        const [px, py] = pixelAt(side.lattice, x, y);
        if (Number.isNaN(px + py)) continue;
        [window[0], window[1], window[2], window[3]] = [Math.min(window[0], px), Math.min(window[1], py), Math.max(window[2], px), Math.max(window[3], py)];
      }
    const margin = (window[2] - window[0]) / steps / 4 + 4;
    return [window[0] - margin, window[1] - margin, window[2] + margin, window[3] + margin];
  }

  #latticeOf(side: StereoSide): WebGLTexture {
    const gl = this.#gl;
    const texture = this.#plain(gl.NEAREST);
    const nodes = Float32Array.from(side.lattice.nodes, (value) => value ?? nothing);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RG32F, side.lattice.columns, side.lattice.rows, 0, gl.RG, gl.FLOAT, nodes);
    return texture;
  }

  #plain(filter: number): WebGLTexture {
    const gl = this.#gl;
    const texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + 15);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, name, filter);
    for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
    return texture;
  }

  #at(name: string): WebGLUniformLocation | null {
    let found = this.#places.get(name);
    if (found === undefined) {
      found = this.#gl.getUniformLocation(this.#program, name);
      this.#places.set(name, found);
    }
    return found;
  }
}
