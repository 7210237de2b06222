// D, the largest distance between two vertices: the length that errors are fractions of.

const MOST_PAIRS = 3e7;

/** The largest distance between two of (V, 3) points. */
export function diameterOf(points: Float32Array): number {
  const middle = middleOf(points);
  const count = points.length / 3;
  const reach = new Float64Array(count);
  for (let v = 0; v < count; v += 1) reach[v] = Math.sqrt(squared(points, v, middle, 0));
  const order = Uint32Array.from({ length: count }, (_, i) => i).sort(
    (a, b) => reach[b]! - reach[a]!,
  );
  let best = sweep(points, order[0] ?? 0);
  let pairs = 0;
  // Two points can be no farther apart than both together are from the middle.
  for (let i = 0; i < count && 2 * reach[order[i]!]! > best; i += 1) {
    for (let j = i + 1; j < count; j += 1) {
      const [one, other] = [order[i]!, order[j]!];
      if (reach[one]! + reach[other]! <= best) break;
      best = Math.max(best, Math.sqrt(squared(points, one, points, other)));
      if ((pairs += 1) > MOST_PAIRS) return best; // a sphere: right to a fraction of a thousandth
    }
  }
  return best;
}

/** From a point to the farthest from it, and on from there: nearly the largest distance. */
function sweep(points: Float32Array, start: number): number {
  let best = 0;
  let from = start;
  for (let round = 0; round < 4; round += 1) {
    let farthest = from;
    let most = 0;
    for (let v = 0; v < points.length / 3; v += 1) {
      const distance = squared(points, from, points, v);
      if (distance > most) [most, farthest] = [distance, v];
    }
    best = Math.max(best, Math.sqrt(most));
    from = farthest;
  }
  return best;
}

function middleOf(points: Float32Array): Float64Array {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 1) {
    low[i % 3] = Math.min(low[i % 3]!, points[i]!);
    high[i % 3] = Math.max(high[i % 3]!, points[i]!);
  }
  return Float64Array.from(low, (value, axis) => (value + high[axis]!) / 2);
}

function squared(a: Float32Array, i: number, b: ArrayLike<number>, j: number): number {
  const x = a[3 * i]! - b[3 * j]!;
  const y = a[3 * i + 1]! - b[3 * j + 1]!;
  const z = a[3 * i + 2]! - b[3 * j + 2]!;
  return x * x + y * y + z * z;
}
