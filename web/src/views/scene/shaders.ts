// SPDX-License-Identifier: Apache-2.0
// How points are coloured, and the shading by depth (eye-dome lighting, Boucheny 2009): a pixel is darker the more of its neighbours are nearer.
import { AlwaysDepth, GLSL3, NearestFilter, RawShaderMaterial, DataTexture, LinearFilter, type Texture, Vector2 } from "three";

import { ramp } from "../map/paint";

export const colourings = ["colour", "height", "sigma", "class", "images"] as const;
export type Colouring = (typeof colourings)[number];

/** Colours of the classes of the ASPRS; others by their number. */
const classColours: Record<number, number> = {
  0: 0xb0b0b0, 1: 0x9a9a9a, 2: 0xa87848, 3: 0x9bd770, 4: 0x55ad46, 5: 0x1f7a34, 6: 0xd9483b, 7: 0xff00ff, 9: 0x3c8ce7, 10: 0x7a5cc8, 11: 0x585858, 17: 0xe0a030, 18: 0xff66ff,
};
export const classColour = (number: number): [number, number, number] => {
  const colour = classColours[number] ?? (number * 2654435761) >>> 8;
  return [(colour >> 16) & 255, (colour >> 8) & 255, colour & 255];
};

const row = (colours: [number, number, number][], filter: typeof LinearFilter | typeof NearestFilter): DataTexture => {
  const texture = new DataTexture(new Uint8Array(colours.flatMap((one) => [...one, 255])), colours.length, 1);
  [texture.magFilter, texture.minFilter] = [filter, filter];
  texture.needsUpdate = true;
  return texture;
};

const vertex = `
precision highp float;
in vec3 position; in vec4 colour; in vec4 traits;
uniform mat4 modelMatrix; uniform mat4 viewMatrix; uniform mat4 projectionMatrix;
uniform float size; uniform int colouring; uniform vec2 range; uniform sampler2D ramp; uniform sampler2D classes;
out vec3 shown;
void main() {
  vec4 world = modelMatrix * vec4(position, 1.0);
  gl_PointSize = size;
  gl_Position = colour.a < 0.5 ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * viewMatrix * world;
  float value = colouring == 1 ? world.z : colouring == 2 ? floor(traits.y * 255.0 + 0.5) : floor(traits.z * 255.0 + 0.5);
  if (colouring == 0) shown = colour.rgb;
  else if (colouring == 3) shown = texelFetch(classes, ivec2(int(traits.x * 255.0 + 0.5), 0), 0).rgb;
  else if (colouring != 1 && value < 0.5) shown = vec3(0.5);
  else shown = texture(ramp, vec2(clamp((value - range.x) / (range.y - range.x), 0.0, 1.0) * 0.996 + 0.002, 0.5)).rgb;
}`;

const fragment = `
precision mediump float;
in vec3 shown; out vec4 drawn;
void main() { drawn = vec4(shown, 1.0); }`;

export function pointMaterial(): RawShaderMaterial {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: vertex,
    fragmentShader: fragment,
    uniforms: {
      size: { value: 2 },
      colouring: { value: 0 },
      range: { value: new Vector2(0, 1) },
      ramp: { value: row(Array.from({ length: 256 }, (_, i) => ramp(i / 255)), LinearFilter) },
      classes: { value: row(Array.from({ length: 256 }, (_, i) => classColour(i)), NearestFilter) },
    },
  });
}

const screenVertex = `
precision highp float;
in vec3 position; in vec2 uv; out vec2 at;
void main() { at = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }`;

const shading = `
precision highp float;
in vec2 at; out vec4 drawn;
uniform sampler2D colours; uniform sampler2D depths; uniform vec2 pixel; uniform vec2 range; uniform bool parallel; uniform bool shaded;
float depth(vec2 where) {
  float value = texture(depths, where).r;
  if (value >= 1.0) return -1.0;
  return parallel ? range.x + value * (range.y - range.x) : range.x * range.y / (range.y - value * (range.y - range.x));
}
void main() {
  vec4 colour = texture(colours, at);
  gl_FragDepth = texture(depths, at).r; // what lies over the points may lie behind some
  drawn = colour;
  if (!shaded) return;
  float here = depth(at);
  float darker = 0.0;
  for (int i = 0; i < 4; ++i) {
    vec2 by = 1.5 * pixel * (i == 0 ? vec2(1, 0) : i == 1 ? vec2(-1, 0) : i == 2 ? vec2(0, 1) : vec2(0, -1));
    float there = depth(at + by);
    if (there > 0.0) darker += here > 0.0 ? max(0.0, log2(here) - log2(there)) : 0.02;
  }
  drawn = vec4(here > 0.0 ? colour.rgb * exp(-6.0 * min(darker, 0.25)) : colour.rgb, colour.a);
}`;

export function shadingMaterial(colours: Texture, depths: Texture): RawShaderMaterial {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: screenVertex,
    fragmentShader: shading,
    depthFunc: AlwaysDepth,
    uniforms: { colours: { value: colours }, depths: { value: depths }, pixel: { value: new Vector2() }, range: { value: new Vector2() }, parallel: { value: false }, shaded: { value: true } },
  });
}
