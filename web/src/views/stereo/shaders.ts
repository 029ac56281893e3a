// SPDX-License-Identifier: Apache-2.0
// A fragment of the screen to its pixel of the photograph by the lattice, and to a tile of the pyramid by a table of pages.
export const displays = ["anaglyph", "anaglyph_colour", "parallel", "crossed", "interlaced", "flip", "left"] as const;
export type Display = (typeof displays)[number];

export const vertexShader = `#version 300 es
void main() {
  vec2 corner = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  gl_Position = vec4(corner, 0.0, 1.0);
}`;

const eye = (name: string): string => `
vec3 ${name}_texel(ivec2 at) {
  at = clamp(at, ivec2(0), u_${name}_level - 1);
  ivec2 tile = at / TILE;
  uvec2 page = texelFetch(u_${name}_pages, tile, 0).rg;
  if (page.r == 0u) return GROUND;
  int down = int(page.g);
  ivec2 there = at >> down;
  return texelFetch(u_${name}_tiles, ivec3(there - (tile >> down) * TILE, int(page.r) - 1), 0).rgb;
}
vec3 ${name}_photo(vec2 pixel) {
  vec2 at = pixel * u_${name}_reduction;
  ivec2 tile = ivec2(floor(at)) / TILE;
  uvec2 page = texelFetch(u_${name}_pages, tile, 0).rg;
  if (page.r == 0u) return GROUND;
  float down = exp2(float(page.g));
  vec2 inside = at / down - vec2((tile >> int(page.g)) * TILE);
  vec2 limit = min(vec2(TILE), ceil(vec2(u_${name}_level) / down) - vec2((tile >> int(page.g)) * TILE));
  // The sampler interpolates inside of a tile; across its rim four texels of neighbours are fetched.
  if (page.g > 0u || (all(greaterThanEqual(inside, vec2(0.5))) && all(lessThanEqual(inside, limit - 0.5))))
    return textureLod(u_${name}_tiles, vec3(clamp(inside, vec2(0.5), limit - 0.5) / float(TILE), float(page.r) - 1.0), 0.0).rgb;
  vec2 corner = floor(at - 0.5);
  vec2 part = at - 0.5 - corner;
  ivec2 c = ivec2(corner);
  vec3 above = mix(${name}_texel(c), ${name}_texel(c + ivec2(1, 0)), part.x);
  vec3 below = mix(${name}_texel(c + ivec2(0, 1)), ${name}_texel(c + ivec2(1, 1)), part.x);
  return mix(above, below, part.y);
}
vec3 ${name}_eye(vec2 from_middle) {
  vec2 node = (u_${name}_middle + from_middle * u_per_screen) / u_${name}_step;
  ivec2 size = textureSize(u_${name}_lattice, 0);
  vec3 colour = GROUND;
  if (node.x >= 0.0 && node.y >= 0.0 && node.x <= float(size.x - 1) && node.y <= float(size.y - 1)) {
    ivec2 c = min(ivec2(node), size - 2);
    vec2 part = node - vec2(c);
    vec2 a = texelFetch(u_${name}_lattice, c, 0).rg, b = texelFetch(u_${name}_lattice, c + ivec2(1, 0), 0).rg;
    vec2 d = texelFetch(u_${name}_lattice, c + ivec2(0, 1), 0).rg, e = texelFetch(u_${name}_lattice, c + ivec2(1, 1), 0).rg;
    vec2 pixel = mix(mix(a, b, part.x), mix(d, e, part.x), part.y);
    if (min(min(a.x, b.x), min(d.x, e.x)) > NOTHING && all(greaterThanEqual(pixel, vec2(0))) && all(lessThan(pixel, u_${name}_size)))
      colour = clamp((${name}_photo(pixel) - 0.5) * u_contrast + 0.5 + u_brightness, 0.0, 1.0);
  }
  vec4 over = texture(u_${name}_over, from_middle / u_viewport + 0.5);
  return mix(colour, over.rgb / max(over.a, 0.001), over.a);
}`;

const uniforms = (name: string): string => `
uniform sampler2D u_${name}_lattice;
uniform mediump sampler2DArray u_${name}_tiles;
uniform highp usampler2D u_${name}_pages;
uniform sampler2D u_${name}_over;
uniform vec2 u_${name}_middle;
uniform vec2 u_${name}_size;
uniform ivec2 u_${name}_level;
uniform float u_${name}_reduction;
uniform float u_${name}_step;`;

/** Grey anaglyphs have the luma of each eye; those in colour are the least-squares matrices of Dubois (2001) for red and cyan. */
export const fragmentShader = `#version 300 es
precision highp float;
precision highp int;
const int TILE = 256;
const float NOTHING = -1e5;
const vec3 GROUND = vec3(0.133, 0.149, 0.165);
uniform vec2 u_screen;
uniform vec2 u_viewport;
uniform float u_per_screen;
uniform int u_display;
uniform int u_phase;
uniform float u_contrast;
uniform float u_brightness;
${uniforms("left")}
${uniforms("right")}
out vec4 colour;
${eye("left")}
${eye("right")}
const vec3 LUMA = vec3(0.299, 0.587, 0.114);
const mat3 LEFT = mat3(0.437, -0.062, -0.048, 0.449, -0.062, -0.050, 0.164, -0.024, -0.017);
const mat3 RIGHT = mat3(-0.011, 0.377, -0.026, -0.032, 0.761, -0.093, -0.007, 0.009, 1.234);
void main() {
  vec2 at = vec2(gl_FragCoord.x, u_screen.y - gl_FragCoord.y);
  vec3 shown;
  if (u_display == 0) {
    shown = vec3(dot(left_eye(at - u_screen / 2.0), LUMA), vec2(dot(right_eye(at - u_screen / 2.0), LUMA)));
  } else if (u_display == 1) {
    shown = LEFT * left_eye(at - u_screen / 2.0) + RIGHT * right_eye(at - u_screen / 2.0);
  } else if (u_display == 2) {
    bool first = at.x < u_screen.x / 2.0;
    vec2 middle = vec2(u_screen.x * (first ? 0.25 : 0.75), u_screen.y / 2.0);
    bool takes_left = first != (u_phase == 1);
    if (takes_left) shown = left_eye(at - middle); else shown = right_eye(at - middle);
    if (abs(at.x - u_screen.x / 2.0) < 1.0) shown = vec3(0.0);
  } else {
    bool takes_left = u_display == 3 ? (int(at.y) % 2 == 0) != (u_phase == 1) : u_phase == 0;
    if (takes_left) shown = left_eye(at - u_screen / 2.0); else shown = right_eye(at - u_screen / 2.0);
  }
  colour = vec4(clamp(shown, 0.0, 1.0), 1.0);
}`;
