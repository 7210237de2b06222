// Whether left and right were exchanged: both are the subject's own.
import { determinant } from './cameras';
import type { Mark, Point } from '../types/task';

/** Points that come in twos, the subject's right one first. */
export const PAIRS: readonly (readonly [string, string])[] = [
  ['right_eye_outer', 'left_eye_outer'],
  ['right_eye_inner', 'left_eye_inner'],
  ['right_nostril', 'left_nostril'],
  ['mouth_right', 'mouth_left'],
  ['right_jaw', 'left_jaw'],
];

const UPPER = ['right_eye_outer', 'left_eye_outer', 'right_eye_inner', 'left_eye_inner', 'nose_bridge'];
const LOWER = ['mouth_right', 'mouth_left', 'upper_lip', 'lower_lip', 'chin'];
const FRONT = ['nose_tip', 'upper_lip', 'lower_lip', 'chin', 'nose_bridge'];

// Of the height from eyes to mouth. From the side the points of a pair lie almost one over the other
// in a photograph, and beyond that they change places: only what is well apart tells something.
const [APART_IN_PHOTOGRAPHS, APART_IN_SPACE] = [0.3, 0.12];

type Own = Readonly<Record<string, Mark>>;

/** Pairs whose points stand on each other's side; empty where all is well or cannot be told. */
export function exchanged(own: Own, flat: boolean): readonly (readonly [string, string])[] {
  const [top, bottom] = [middle(own, UPPER), middle(own, LOWER)];
  if (!top || !bottom) return [];
  const down = minus(bottom, top);
  const height = Math.hypot(...down);
  const across = PAIRS.filter(([right, left]) => own[right] && own[left]).map(
    (pair) => [pair, minus(at(own[pair[1]]!), at(own[pair[0]]!))] as const,
  );
  const side = ([, way]: (typeof across)[number]) => {
    if (flat) return (way[0] * down[1] - way[1] * down[0]) / height ** 2;
    const front = middle(own, FRONT);
    const sides = middle(own, ['right_eye_outer', 'left_eye_outer', 'mouth_right', 'mouth_left']);
    if (!front || !sides) return 0;
    const ahead = minus(front, sides);
    return determinant(way, minus([0, 0, 0], down), ahead) / (height ** 2 * Math.hypot(...ahead));
  };
  const apart = flat ? APART_IN_PHOTOGRAPHS : APART_IN_SPACE;
  return across.filter((one) => side(one) < -apart).map(([pair]) => pair);
}

/** The marks with the two points of these pairs exchanged. */
export function putRight(own: Own, pairs: readonly (readonly [string, string])[]): Own {
  const swapped: Record<string, Mark> = { ...own };
  for (const [right, left] of pairs) {
    const [a, b] = [own[right], own[left]];
    if (a && b) [swapped[right], swapped[left]] = [b, a];
  }
  return swapped;
}

function at({ at: [x = 0, y = 0, z = 0] }: Mark): Point {
  return [x, y, z];
}

function minus(a: Point, b: Point): Point {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** Middle of pairs of which both are there, and of points that stand in the middle themselves. */
function middle(own: Own, names: readonly string[]): Point | null {
  const found = names.filter((name) => own[name]).map((name) => at(own[name]!));
  if (found.length === 0) return null;
  return [0, 1, 2].map(
    (i) => found.reduce((sum, point) => sum + point[i]!, 0) / found.length,
  ) as unknown as Point;
}
