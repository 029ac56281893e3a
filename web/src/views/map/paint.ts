// SPDX-License-Identifier: Apache-2.0
// Cells of rasters as colours: four bytes (red, green, blue, opacity) each.

export type Bands = ArrayLike<number>[];

/** One grey band, three of colour, or those and opacity. */
export function paintedColours(bands: Bands, nodata: number | null): Uint8ClampedArray {
  const [red = [], green = red, blue = red] = bands.length >= 3 ? bands : [bands[0] ?? []];
  const opacity = bands[3] ?? (bands.length === 2 ? bands[1] : undefined);
  const out = new Uint8ClampedArray(4 * red.length);
  for (let i = 0, j = 0; i < red.length; ++i, j += 4) {
    out[j] = red[i] as number;
    out[j + 1] = green[i] as number;
    out[j + 2] = blue[i] as number;
    out[j + 3] = opacity ? (opacity[i] as number) : bands.length === 1 && red[i] === nodata ? 0 : 255;
  }
  return out;
}

// Viridis (van der Walt and Smith), at equal steps.
const stops = [0x440154, 0x482878, 0x3e4989, 0x31688e, 0x26828e, 0x1f9e89, 0x35b779, 0x6ece58, 0xb5de2b, 0xfde725];

/** The same as a background of the page, from left to right. */
export const rampCss = `linear-gradient(to right, ${stops.map((stop) => `#${stop.toString(16).padStart(6, "0")}`).join(", ")})`;

/** A colour of a value in [0, 1]; beyond, that of the end. */
export function ramp(value: number): [number, number, number] {
  const at = Math.min(Math.max(value, 0), 1) * (stops.length - 1);
  const below = Math.min(Math.floor(at), stops.length - 2);
  const share = at - below;
  const [from, to] = [stops[below] as number, stops[below + 1] as number];
  const mixed = (shift: number): number => Math.round(((from >> shift) & 255) * (1 - share) + ((to >> shift) & 255) * share);
  return [mixed(16), mixed(8), mixed(0)];
}

/** Numbers that stand for something, each in a colour of its own: neighbours far apart on the circle of hues. */
export function paintedClasses(band: ArrayLike<number>, none: number): Uint8ClampedArray {
  const out = new Uint8ClampedArray(4 * band.length);
  const known = new Map<number, [number, number, number]>();
  for (let i = 0, j = 0; i < band.length; ++i, j += 4) {
    const value = band[i] as number;
    if (value === none) continue;
    let colour = known.get(value);
    if (!colour) known.set(value, (colour = hue(value * 0.381966)));
    [out[j], out[j + 1], out[j + 2]] = colour;
    out[j + 3] = 255;
  }
  return out;
}

/** A full colour of the circle of hues, of which only the part behind the point counts. */
function hue(turn: number): [number, number, number] {
  const at = (shift: number): number => {
    const part = ((turn + shift) % 1) * 6;
    return Math.round(255 * Math.min(1, Math.max(0, Math.abs(part - 3) - 1)));
  };
  return [at(0), at(2 / 3), at(1 / 3)];
}

/** Values from `low` to `high` by the ramp; what is not known stays clear. */
export function paintedValues(band: ArrayLike<number>, nodata: number | null, low: number, high: number): Uint8ClampedArray {
  const out = new Uint8ClampedArray(4 * band.length);
  for (let i = 0, j = 0; i < band.length; ++i, j += 4) {
    const value = band[i] as number;
    if (value === nodata || !Number.isFinite(value)) continue;
    [out[j], out[j + 1], out[j + 2]] = ramp((value - low) / (high - low));
    out[j + 3] = 255;
  }
  return out;
}
