// Affine maps of vertices: of a node, or of the joints that hold each of them.

/** Twelve numbers: what x, y and z are multiplied with, then what is added; by columns. */
export type Placement = readonly number[];

export const UNIT: Placement = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];

/** Half a turn about the upright axis. */
export const AROUND: Placement = [-1, 0, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0];

/** First the inner map, then the outer. */
export function product(outer: Placement, inner: Placement): Placement {
  return [0, 1, 2, 3].flatMap((column) =>
    [0, 1, 2].map((row) => {
      const sum = [0, 1, 2].reduce((s, k) => s + outer[3 * k + row]! * inner[3 * column + k]!, 0);
      return column === 3 ? sum + outer[9 + row]! : sum;
    }),
  );
}

/** Moves (V, 3) positions, or turns (V, 3) directions, in place. */
export function place(vectors: Float32Array, m: Placement, kind: 'positions' | 'directions'): void {
  if (m.every((value, i) => value === UNIT[i])) return;
  const [dx, dy, dz] = kind === 'positions' ? [m[9]!, m[10]!, m[11]!] : [0, 0, 0];
  for (let i = 0; i < vectors.length; i += 3) {
    const [x, y, z] = [vectors[i]!, vectors[i + 1]!, vectors[i + 2]!];
    vectors[i] = m[0]! * x + m[3]! * y + m[6]! * z + dx;
    vectors[i + 1] = m[1]! * x + m[4]! * y + m[7]! * z + dy;
    vectors[i + 2] = m[2]! * x + m[5]! * y + m[8]! * z + dz;
  }
}

/** As `place`, each vector by the twelve numbers of its own. */
export function placeEach(
  vectors: Float32Array,
  held: Float32Array,
  kind: 'positions' | 'directions',
): void {
  const moved = kind === 'positions' ? 1 : 0;
  for (let i = 0; i < vectors.length; i += 3) {
    const [x, y, z] = [vectors[i]!, vectors[i + 1]!, vectors[i + 2]!];
    const m = 4 * i;
    for (let row = 0; row < 3; row += 1)
      vectors[i + row] =
        held[m + row]! * x +
        held[m + 3 + row]! * y +
        held[m + 6 + row]! * z +
        moved * held[m + 9 + row]!;
  }
}

/** Whether a placement turns triangles inside out. */
export function mirrors(m: Placement): boolean {
  const [a, b, c, d, e, f, g, h, i] = m as [
    number,
    number,
    number,
    number,
    number,
    number,
    number,
    number,
    number,
  ];
  return a * (e * i - f * h) - d * (b * i - c * h) + g * (b * f - c * e) < 0;
}
