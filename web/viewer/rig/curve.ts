// Bend curves: the weight of a bend at a time of its path.
import type { BendCurve } from '../types/model';

/** The curve at a time: zero at both ends, straight on along its end tangents beyond them. */
export function bendWeight(curve: BendCurve, t: number): number {
  if (t <= 0) return t * slope(curve, 0);
  if (t >= 1) return (t - 1) * slope(curve, 1);
  const [coefficients, s] = piece(curve, t);
  return coefficients.reduceRight((sum, a) => sum * s + a, 0);
}

function slope(curve: BendCurve, t: number): number {
  const [coefficients, s] = piece(curve, t);
  return coefficients.reduceRight((sum, a, n) => (n === 0 ? sum : sum * s + n * a), 0);
}

/** The coefficients that hold at a time, and the time since their break. */
function piece({ breaks, coefficients }: BendCurve, t: number): [readonly number[], number] {
  let low = 0;
  let high = coefficients.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if ((breaks[middle] ?? 0) <= t) low = middle;
    else high = middle - 1;
  }
  return [coefficients[low] ?? [], t - (breaks[low] ?? 0)];
}
