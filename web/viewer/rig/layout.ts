// How vertices lie in textures: rows of texels, so that any number fits every graphics card.

const WIDEST = 4096;

export interface Texels {
  readonly width: number;
  readonly rows: number;
}

/** The texels of one shape: vertex v is at column v mod width of row v div width. */
export function texelsOf(vertices: number): Texels {
  const rows = Math.max(1, Math.ceil(vertices / WIDEST));
  return { width: Math.max(1, Math.ceil(vertices / rows)), rows };
}

/** Shapes (V, 3) that lie in one stretch of memory as their texture wants them. */
export function shapesInOne(count: number, vertices: number): Float32Array[] {
  const { width, rows } = texelsOf(vertices);
  const step = 3 * width * rows;
  const all = new Float32Array(count * step);
  return Array.from({ length: count }, (_, i) => all.subarray(i * step, i * step + 3 * vertices));
}

/** The stretch of memory, if these shapes lie in one as `shapesInOne` makes it. */
export function oneStretch(shapes: readonly Float32Array[], vertices: number): Float32Array | null {
  const { width, rows } = texelsOf(vertices);
  const step = 3 * width * rows;
  const first = shapes[0];
  if (!first) return null;
  const { buffer, byteOffset } = first;
  const inOrder = shapes.every(
    (s, i) => s.buffer === buffer && s.byteOffset === byteOffset + 4 * step * i,
  );
  const fits = byteOffset + 4 * step * shapes.length <= buffer.byteLength;
  return inOrder && fits ? new Float32Array(buffer, byteOffset, step * shapes.length) : null;
}
