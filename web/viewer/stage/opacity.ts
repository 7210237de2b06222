// How much of a dressed part is there at a place on it, as far as its images say.
import type { Layer, Model, Part, Wrap } from '../types/model';

const FINEST = 512; // pixels on a side of what is kept of an image
const THERE = 0.4; // of what blends: what lets more light through is looked and reached through

interface Opacities {
  readonly width: number;
  readonly height: number;
  readonly alpha: Uint8Array;
}

const known = new WeakMap<ImageBitmap, Opacities>();

/** Whether a part is seen within a triangle, whose first corner is `i`, u and v along its sides. */
export function isThere(model: Model, { skin }: Part, i: number, u: number, v: number): boolean {
  if (!skin || skin.opacity === 'opaque') return true;
  const { triangles, colours } = model;
  const between = (values: ArrayLike<number>, width: number, column: number) =>
    [1 - u - v, u, v].reduce(
      (sum, share, corner) => sum + share * values[width * triangles[i + corner]! + column]!,
      0,
    );
  let opacity = skin.colour[3] * (colours ? between(colours, 4, 3) / 255 : 1);
  const base = skin.layers.base;
  const uv = base && (model.uv[base.set] ?? model.uv[0]);
  if (uv) opacity *= opacityAt(base, between(uv, 2, 0), between(uv, 2, 1));
  return opacity >= (skin.opacity === 'mask' ? skin.cutoff : THERE);
}

function opacityAt({ image, place, wrap }: Layer, u: number, v: number): number {
  const [a, b, c, d, x, y] = place as [number, number, number, number, number, number];
  const { width, height, alpha } = opacitiesOf(image);
  const column = Math.floor(width * wrapped(a * u + c * v + x, wrap[0]));
  const row = Math.floor(height * wrapped(b * u + d * v + y, wrap[1]));
  return alpha[Math.min(row, height - 1) * width + Math.min(column, width - 1)]! / 255;
}

function wrapped(at: number, wrap: Wrap): number {
  if (wrap === 'clamp') return Math.min(Math.max(at, 0), 1);
  const turn = wrap === 'mirror' ? 2 : 1;
  const within = at - turn * Math.floor(at / turn);
  return within > 1 ? 2 - within : within;
}

function opacitiesOf(image: ImageBitmap): Opacities {
  const found = known.get(image);
  if (found) return found;
  const share = Math.min(1, FINEST / Math.max(image.width, image.height));
  const [width, height] = [image.width, image.height].map((side) =>
    Math.max(1, Math.round(side * share)),
  ) as [number, number];
  const context = new OffscreenCanvas(width, height).getContext('2d')!;
  context.drawImage(image, 0, 0, width, height);
  const { data } = context.getImageData(0, 0, width, height);
  const made = { width, height, alpha: Uint8Array.from({ length: width * height }, (_, p) => data[4 * p + 3]!) };
  known.set(image, made);
  return made;
}
