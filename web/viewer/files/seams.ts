// Which vertices are copies of one another at texture seams, where a file does not say.
import type { Surface } from './surface';

/**
 * (V,) the first vertex at the same place that has the same normal and moves alike in every morph
 * target. What only touches at rest, as closed lips do, or has a hard edge, stays apart: normals
 * are the same where the cosine between them is at least `alike`.
 */
export function seamsOf({ neutral, normals, targets }: Surface, alike = 0.999): Uint32Array {
  const bits = new Uint32Array(neutral.buffer, neutral.byteOffset, neutral.length);
  const atPlace = new Map<string, number[]>();
  const seams = new Uint32Array(neutral.length / 3);
  for (let v = 0; v < seams.length; v += 1) {
    const place = `${bits[3 * v]},${bits[3 * v + 1]},${bits[3 * v + 2]}`;
    const others = atPlace.get(place);
    const same = others?.find(
      (other) =>
        sameNormal(normals, v, other, alike) && targets.every((target) => equal(target, v, other)),
    );
    seams[v] = same ?? v;
    if (!others) atPlace.set(place, [v]);
    else if (same === undefined) others.push(v);
  }
  return seams;
}

function sameNormal(
  normals: Float32Array | null,
  one: number,
  other: number,
  alike: number,
): boolean {
  if (!normals) return true;
  const dot = [0, 1, 2].reduce(
    (sum, axis) => sum + normals[3 * one + axis]! * normals[3 * other + axis]!,
    0,
  );
  return dot > alike;
}

function equal(shape: Float32Array, one: number, other: number): boolean {
  return [0, 1, 2].every(
    (axis) =>
      Math.abs(shape[3 * one + axis]! - shape[3 * other + axis]!) <
      1e-7 + 1e-5 * Math.abs(shape[3 * one + axis]!),
  );
}
