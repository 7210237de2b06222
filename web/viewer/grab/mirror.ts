// The other side of a face: the vertex across its plane of symmetry, and the halves of expressions.
import { twins } from '../interface/names/pairs';
import type { Weights } from '../rig/pose';
import type { Model } from '../types/model';

const NEAR = 0.004; // of D: no farther from its mirror image is the vertex of a symmetric face

/** The plane of equal x that halves the neutral. */
export function middleOf({ neutral }: Model): number {
  let low = Infinity;
  let high = -Infinity;
  for (let i = 0; i < neutral.length; i += 3) {
    low = Math.min(low, neutral[i]!);
    high = Math.max(high, neutral[i]!);
  }
  return (low + high) / 2;
}

/** The vertex on the other side, the vertex itself in the middle; null where there is none. */
export function acrossFrom(model: Model, vertex: number): number | null {
  const { neutral, diameter, seams } = model;
  const [x, y, z] = [0, 1, 2].map((axis) => neutral[3 * vertex + axis]!) as [number, number, number];
  const mirrored = 2 * middleOf(model) - x;
  if (Math.abs(mirrored - x) < 2 * NEAR * diameter) return vertex;
  let nearest: number | null = null;
  let least = NEAR * diameter;
  for (let v = 0; v < neutral.length / 3; v += 1) {
    const away = Math.hypot(
      neutral[3 * v]! - mirrored,
      neutral[3 * v + 1]! - y,
      neutral[3 * v + 2]! - z,
    );
    if (away < least) [least, nearest] = [away, v];
  }
  return nearest === null ? null : seams[nearest]!;
}

/** The same weights, where of each pair both halves are where the one is that moved farther. */
export function evened({ sliders }: Model, weights: Weights, start: Weights): Weights {
  const both: Record<string, number> = { ...weights };
  const moved = (name: string) => Math.abs((weights[name] ?? 0) - (start[name] ?? 0));
  for (const [name, twin] of twins(sliders))
    if (moved(name) > moved(twin)) both[twin] = weights[name] ?? 0;
  return both;
}
