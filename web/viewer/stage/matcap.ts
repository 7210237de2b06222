// A lit ball of clay as a picture: what a matcap looks a normal up in.
import {
  ClampToEdgeWrapping,
  DataTexture,
  HalfFloatType,
  LinearFilter,
  RGBAFormat,
  DataUtils,
} from 'three';

const SIZE = 128;
const CLAY = [0.4, 0.25, 0.19] as const;

type Vector = readonly [number, number, number];

/** The picture, in linear light. */
export function clayMatcap(): DataTexture {
  const pixels = new Uint16Array(4 * SIZE * SIZE);
  for (let row = 0; row < SIZE; row += 1) {
    for (let column = 0; column < SIZE; column += 1) {
      const light = ballAt((2 * column + 1) / SIZE - 1, (2 * row + 1) / SIZE - 1);
      pixels.set([...light, 1].map(DataUtils.toHalfFloat), 4 * (row * SIZE + column));
    }
  }
  const texture = new DataTexture(pixels, SIZE, SIZE, RGBAFormat, HalfFloatType);
  texture.minFilter = LinearFilter;
  texture.magFilter = LinearFilter;
  texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
  texture.needsUpdate = true;
  return texture;
}

function ballAt(x: number, y: number): Vector {
  const out = Math.min(Math.hypot(x, y) / 0.98, 1);
  const scale = Math.hypot(x, y) > 0 ? out / Math.hypot(x, y) : 0;
  const n: Vector = [x * scale, y * scale, Math.sqrt(Math.max(0, 1 - out * out))];
  const key = lambert(n, [-0.45, 0.62, 0.64], 0.22);
  const fill = lambert(n, [0.75, -0.15, 0.64], 0.4);
  const dome = 0.5 + 0.5 * n[1];
  const edge = (1 - n[2]) ** 3;
  const rim = edge * lambert(n, [0.7, 0.6, -0.2], 0.3);
  const gloss = 0.16 * Math.max(0, half(n, [-0.45, 0.62, 0.64])) ** 22;
  return [0, 1, 2].map((c) => {
    const warm = [1.04, 0.98, 0.93][c]!;
    const cool = [0.85, 0.97, 1.12][c]!;
    const lit = 0.95 * key * warm + 0.2 * fill * cool + 0.2 * dome * cool + 0.05;
    return (CLAY[c]! * lit + gloss + 0.45 * rim * cool) * (1 - 0.35 * edge * (1 - rim));
  }) as unknown as Vector;
}

function lambert(n: Vector, towards: Vector, wrap: number): number {
  return Math.max(0, (along(n, towards) + wrap) / (1 + wrap));
}

function half(n: Vector, towards: Vector): number {
  const l = Math.hypot(...towards);
  return along(n, [towards[0] / l, towards[1] / l, towards[2] / l + 1]);
}

function along(n: Vector, towards: Vector): number {
  return (n[0] * towards[0] + n[1] * towards[1] + n[2] * towards[2]) / Math.hypot(...towards);
}
