// Eyeballs that show no iris of their own, because theirs is an image or lies behind a cornea.
import type { Part } from '../types/model';

const ROUND = 0.75; // smallest over largest side of the box round a shell that may be an eyeball

/**
 * The ball that an iris is drawn on, or nothing where this is no eyeball or an iris lies before it.
 *
 * @param ball vertices of one connected shell of eye white
 * @param inner vertices of the irises and pupils that the face has of its own
 */
export function eyeOf(
  neutral: Float32Array,
  ball: readonly number[],
  inner: readonly number[],
): Part['eye'] {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const v of ball) {
    for (const axis of [0, 1, 2]) {
      low[axis] = Math.min(low[axis]!, neutral[3 * v + axis]!);
      high[axis] = Math.max(high[axis]!, neutral[3 * v + axis]!);
    }
  }
  const sides = high.map((value, axis) => value - low[axis]!);
  if (!(Math.min(...sides) >= ROUND * Math.max(...sides))) return undefined;
  const radius = (sides[0]! + sides[1]!) / 4;
  // A cornea may bulge in front; nothing does behind.
  const middle = [(low[0]! + high[0]!) / 2, (low[1]! + high[1]!) / 2, low[2]! + radius] as const;
  const before = inner.some(
    (v) =>
      Math.hypot(neutral[3 * v]! - middle[0], neutral[3 * v + 1]! - middle[1]) < radius / 2 &&
      neutral[3 * v + 2]! >= high[2]! - 0.01 * radius,
  );
  return before ? undefined : { middle, radius };
}
