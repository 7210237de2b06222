// The other side of a face: the vertex across its plane of symmetry, and the halves of expressions.
import { numberOf, numbersByName } from '../../shared/named';
import { twins } from '../interface/names/pairs';
import type { Weights } from '../rig/pose';
import { movedVertices } from '../rig/surface';
import type { Model } from '../types/model';

const NEAR = 0.004; // of D: no farther from its mirror image is the vertex of a symmetric face
const SOME = 60; // points that tell which plane it is
const middles = new WeakMap<Model, number>();

/**
 * The plane of equal x that halves the face: of the middle of all there is, which hair or a body may
 * lean away from, that of what moves, and 0, the one across which most of some points have a twin.
 */
function middleOf(model: Model): number {
  const known = middles.get(model);
  if (known !== undefined) return known;
  const deltas = model.morphs.map(({ delta }) => model.targets[delta]!);
  const moved = movedVertices(deltas, model.neutral.length / 3);
  const between = (vertices: Iterable<number>) => {
    let [low, high] = [Infinity, -Infinity];
    for (const v of vertices) {
      const x = model.neutral[3 * v]!;
      [low, high] = [Math.min(low, x), Math.max(high, x)];
    }
    return (low + high) / 2;
  };
  const some = moved.filter((_, i) => i % Math.ceil(moved.length / SOME) === 0);
  const twinned = (middle: number) =>
    some.filter((v) => vertexAcross(model, v, middle) !== null).length;
  const planes = [between(Array(model.neutral.length / 3).keys()), between(moved), 0];
  const counts = planes.map((plane) => (Number.isFinite(plane) ? twinned(plane) : -1));
  const middle = planes[counts.indexOf(Math.max(...counts))]!;
  middles.set(model, middle);
  return middle;
}

/** The vertex on the other side, the vertex itself in the middle; null where there is none. */
export function acrossFrom(model: Model, vertex: number): number | null {
  return vertexAcross(model, vertex, middleOf(model));
}

function vertexAcross(model: Model, vertex: number, middle: number): number | null {
  const { neutral, diameter, seams } = model;
  const [x, y, z] = [0, 1, 2].map((axis) => neutral[3 * vertex + axis]!) as [number, number, number];
  const mirrored = 2 * middle - x;
  if (Math.abs(mirrored - x) < 2 * NEAR * diameter) return vertex;
  let nearest: number | null = null;
  let least = NEAR * diameter;
  for (let v = 0; v < neutral.length / 3; v += 1) {
    const aside = Math.abs(neutral[3 * v]! - mirrored);
    if (aside >= least) continue;
    const away = Math.hypot(aside, neutral[3 * v + 1]! - y, neutral[3 * v + 2]! - z);
    if (away < least) [least, nearest] = [away, v];
  }
  return nearest === null ? null : seams[nearest]!;
}

/** The same weights, where of each pair both halves are where the one is that moved farther. */
export function evened({ sliders }: Model, weights: Weights, start: Weights): Weights {
  const both = numbersByName(weights);
  const moved = (name: string) => Math.abs(numberOf(weights, name) - numberOf(start, name));
  for (const [name, twin] of twins(sliders))
    if (moved(name) > moved(twin)) both[twin] = numberOf(weights, name);
  return both;
}
