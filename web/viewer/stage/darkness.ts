// Where a surface is dark, so that lines on it must be light.
import type { Layer, Model, Part } from '../types/model';
import { linear } from '../files/looks';

const SIDE = 128; // pixels of the copy that is looked at
const DARK = 0.07; // luminance, linear, below which dark lines are lost

/** (V,) 1 where a vertex lies on a dark part of an image or a colour. */
export function darkVertices({ parts, neutral, triangles, uv, colours }: Model): Uint8Array {
  const dark = new Uint8Array(neutral.length / 3);
  const pixelsOf = new Map<ImageBitmap, Uint8ClampedArray>();
  for (const part of parts) {
    const layer = part.skin?.layers.base;
    const places = layer && uv[layer.set];
    if (layer && !pixelsOf.has(layer.image)) pixelsOf.set(layer.image, pixels(layer.image));
    for (let i = part.start; i < part.start + part.count; i += 1) {
      const v = triangles[i]!;
      const seen = places ? at(layer, pixelsOf.get(layer.image)!, places, v) : [1, 1, 1];
      const own = colours ? colours.subarray(4 * v, 4 * v + 3) : null;
      dark[v] = luminance(part, seen, own) < DARK ? 1 : 0;
    }
  }
  return dark;
}

function luminance({ colour }: Part, seen: readonly number[], own: Uint8Array | null): number {
  const [r, g, b] = colour.map((part, c) => part * seen[c]! * ((own?.[c] ?? 255) / 255));
  return 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
}

/** The colour of an image at a vertex, linear. */
function at({ place }: Layer, pixels: Uint8ClampedArray, uv: Float32Array, v: number): number[] {
  const [x, y] = [uv[2 * v]!, uv[2 * v + 1]!];
  const [a, b, c, d, e, f] = place as [number, number, number, number, number, number];
  const pixel = (along: number) => Math.floor(SIDE * (along - Math.floor(along))) % SIDE;
  const start = 4 * (SIDE * pixel(b * x + d * y + f) + pixel(a * x + c * y + e));
  return linear([...pixels.subarray(start, start + 3)].map((part) => part / 255));
}

function pixels(image: ImageBitmap): Uint8ClampedArray {
  const context = new OffscreenCanvas(SIDE, SIDE).getContext('2d', { willReadFrequently: true })!;
  context.drawImage(image, 0, 0, SIDE, SIDE);
  return context.getImageData(0, 0, SIDE, SIDE).data;
}
