// Positions summed by the processor: of single vertices along their path, and of whole faces.
import type { Model } from '../types/model';
import { activeTargets, type ActiveTarget, type Drive } from './pose';

/** Writes V₀ + Σ weight · target of all vertices into `out`, (V, 3). */
export function poseInto(out: Float32Array, model: Model, active: readonly ActiveTarget[]): void {
  out.set(model.neutral);
  for (const { target, weight } of active) {
    const moved = model.targets[target];
    if (!moved) continue;
    for (let i = 0; i < out.length; i += 1) out[i]! += weight * moved[i]!;
  }
}

/** (3 · moments) positions of one vertex as t runs evenly from 0 to 1 under the given sliders. */
export function orbit(
  model: Model,
  drive: Drive,
  vertex: number,
  moments: number,
): Float32Array {
  const found = new Float32Array(3 * moments);
  for (let i = 0; i < moments; i += 1) {
    const active = activeTargets(model, { ...drive, t: i / (moments - 1) });
    found.set(vertexAt(model, active, vertex), 3 * i);
  }
  return found;
}

/** Where one vertex is under the given morph targets. */
export function vertexAt(
  model: Model,
  active: readonly ActiveTarget[],
  vertex: number,
): [number, number, number] {
  const at = (axis: number) =>
    active.reduce(
      (sum, { target, weight }) => sum + weight * (model.targets[target]?.[3 * vertex + axis] ?? 0),
      model.neutral[3 * vertex + axis] ?? 0,
    );
  return [at(0), at(1), at(2)];
}

// A quarter of each has two digits: the marks of a scale. The pictures of the package have the same.
const ENDS = [1, 1.2, 1.6, 2, 2.4, 3.2, 4, 6, 8, 10];

/** The end of a scale of at least `value`: the least of ENDS times a power of ten. */
export function roundedUp(value: number): number {
  if (!(value > 0) || !Number.isFinite(value)) return 0;
  const power = 10 ** Math.floor(Math.log10(value));
  // The tolerance keeps 0.3 − 0.1 and the like from being rounded up to the next step.
  const step = ENDS.find((s) => s * power >= value * (1 - 1e-9)) ?? 10;
  return step * power;
}

/** Largest and mean distance between two faces, and the vertex where it is largest. */
export function distances(one: Float32Array, other: Float32Array) {
  let largest = 0;
  let sum = 0;
  let worstVertex = 0;
  const count = Math.min(one.length, other.length) / 3;
  for (let v = 0; v < count; v += 1) {
    const x = one[3 * v]! - other[3 * v]!;
    const y = one[3 * v + 1]! - other[3 * v + 1]!;
    const z = one[3 * v + 2]! - other[3 * v + 2]!;
    const distance = Math.sqrt(x * x + y * y + z * z);
    sum += distance;
    if (distance > largest) [largest, worstVertex] = [distance, v];
  }
  return { largest, mean: count > 0 ? sum / count : 0, worstVertex };
}

/** The vertices that any of some (V, 3) displacements moves, of so many. */
export function movedVertices(deltas: readonly Float32Array[], count: number): number[] {
  const moves = (v: number) =>
    deltas.some((delta) => delta[3 * v] || delta[3 * v + 1] || delta[3 * v + 2]);
  return Array.from({ length: count }, (_, v) => v).filter(moves);
}
