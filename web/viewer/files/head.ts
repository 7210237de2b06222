// Where the head of a whole character is: what its targets move tells, and the hair around that.
import type { Surface } from './surface';

const BODY = 3.5; // a mesh so many times as large as what its targets move is more than a head
const HEAD = 1 / 9; // least size of a head over that of its body
const MOVED = 0.05; // of the largest motion: below it a vertex is carried along at the neck
const [ABOVE, BESIDE, BELOW] = [0.7, 0.35, 0.15]; // hair and shoulders, over the size of the face

/** (V,) 1 at the head and what is around it; null where the mesh is no more than that. */
export function headOf({ neutral, targets }: Surface): Uint8Array<ArrayBuffer> | null {
  const count = neutral.length / 3;
  const motion = new Float32Array(count);
  for (const target of targets) {
    for (let v = 0; v < count; v += 1) {
      const way = Math.hypot(target[3 * v]!, target[3 * v + 1]!, target[3 * v + 2]!);
      if (way > motion[v]!) motion[v] = way;
    }
  }
  const most = motion.reduce((a, b) => Math.max(a, b), 0);
  if (most === 0) return null;
  const face = boxOf(neutral, (v) => motion[v]! > MOVED * most);
  const moved = Math.max(...face.sides);
  const whole = Math.max(...boxOf(neutral, () => true).sides);
  if (whole < BODY * moved) return null;
  const size = Math.max(moved, HEAD * whole);
  const reach = (axis: number, side: number, share: number) => {
    const [low, high] = [face.low[axis]!, face.high[axis]!];
    const least = (low + high + side * size) / 2;
    return side < 0 ? Math.min(low, least) - share * size : Math.max(high, least) + share * size;
  };
  const low = [BESIDE, BELOW, ABOVE].map((share, axis) => reach(axis, -1, share));
  const high = [BESIDE, ABOVE, ABOVE].map((share, axis) => reach(axis, 1, share));
  return Uint8Array.from({ length: count }, (_, v) =>
    [0, 1, 2].every((axis) => {
      const at = neutral[3 * v + axis]!;
      return at >= low[axis]! && at <= high[axis]!;
    })
      ? 1
      : 0,
  );
}

function boxOf(points: Float32Array, counts: (vertex: number) => boolean) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let v = 0; v < points.length / 3; v += 1) {
    if (!counts(v)) continue;
    for (let axis = 0; axis < 3; axis += 1) {
      const at = points[3 * v + axis]!;
      low[axis] = Math.min(low[axis]!, at);
      high[axis] = Math.max(high[axis]!, at);
    }
  }
  return { low, high, sides: high.map((top, axis) => top - low[axis]!) };
}
