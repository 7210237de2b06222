// A surface as the server sends it, and what a ray meets on it.
import type { Point } from '../types/task';

export interface Part {
  readonly start: number; // of the corners
  readonly count: number;
  readonly image: number; // of the textures, or -1
}

export interface Mesh {
  /** Added to the positions; they are about it, so that few digits are enough. */
  readonly origin: Point;
  readonly positions: Float32Array<ArrayBuffer>;
  readonly normals: Float32Array<ArrayBuffer>;
  readonly uv: Float32Array<ArrayBuffer> | null;
  readonly colours: Uint8Array<ArrayBuffer> | null; // red, green, blue, and one more
  /** (R,) vertex of the author's mesh. */
  readonly sources: Uint32Array<ArrayBuffer>;
  readonly triangles: Uint32Array<ArrayBuffer>;
  readonly edges: Uint32Array<ArrayBuffer>;
  readonly parts: readonly Part[];
  /** (author's vertices,) one of ours for each. */
  readonly own: ReadonlyMap<number, number>;
  readonly low: Point;
  readonly high: Point;
}

interface Header {
  readonly vertices: number;
  readonly triangles: number;
  readonly edges: number;
  readonly origin: Point;
  readonly uv: boolean;
  readonly colours: boolean;
  readonly parts: readonly Part[];
}

/** @throws Error where it is cut off */
export function meshOf(bytes: ArrayBuffer): Mesh {
  const length = new DataView(bytes).getUint32(0, true);
  const header: Header = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  let at = 4 + length;
  const floats = (count: number) => new Float32Array(bytes, (at += 4 * count) - 4 * count, count);
  const whole = (count: number) => new Uint32Array(bytes, (at += 4 * count) - 4 * count, count);
  const { vertices } = header;
  const positions = floats(3 * vertices);
  const uv = header.uv ? floats(2 * vertices) : null;
  const sources = whole(vertices);
  const triangles = whole(3 * header.triangles);
  const edges = whole(2 * header.edges);
  const colours = header.colours ? new Uint8Array(bytes, at, 4 * vertices) : null;
  const own = new Map<number, number>();
  sources.forEach((source, vertex) => own.set(source, vertex));
  return {
    ...{ origin: header.origin, positions, uv, colours, sources, triangles, edges, own },
    ...boxOf(positions, triangles),
    parts: header.parts,
    normals: normalsOf(positions, triangles, sources),
  };
}

/** What a line of sight meets first. */
export interface Met {
  readonly at: Point; // without the origin
  readonly corner: number; // the first of its triangle
  readonly away: number;
}

/** Möller and Trumbore's test over all triangles. */
export function cast({ positions: p, triangles }: Mesh, eye: Point, way: Point): Met | null {
  const [dx, dy, dz] = way;
  let nearest = Infinity;
  let corner = -1;
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = [3 * triangles[i]!, 3 * triangles[i + 1]!, 3 * triangles[i + 2]!];
    const ux = p[b]! - p[a]!, uy = p[b + 1]! - p[a + 1]!, uz = p[b + 2]! - p[a + 2]!;
    const vx = p[c]! - p[a]!, vy = p[c + 1]! - p[a + 1]!, vz = p[c + 2]! - p[a + 2]!;
    const hx = dy * vz - dz * vy, hy = dz * vx - dx * vz, hz = dx * vy - dy * vx;
    const area = ux * hx + uy * hy + uz * hz;
    if (area === 0) continue;
    const sx = eye[0] - p[a]!, sy = eye[1] - p[a + 1]!, sz = eye[2] - p[a + 2]!;
    const u = (sx * hx + sy * hy + sz * hz) / area;
    if (!(u >= 0 && u <= 1)) continue;
    const qx = sy * uz - sz * uy, qy = sz * ux - sx * uz, qz = sx * uy - sy * ux;
    const v = (dx * qx + dy * qy + dz * qz) / area;
    if (!(v >= 0 && u + v <= 1)) continue;
    const away = (vx * qx + vy * qy + vz * qz) / area;
    if (away > 0 && away < nearest) [nearest, corner] = [away, i];
  }
  if (corner < 0) return null;
  return { at: eye.map((value, i) => value + nearest * way[i]!) as never, corner, away: nearest };
}

/** The corner of a triangle that is nearest to a point, of our vertices. */
export function cornerNear({ positions, triangles }: Mesh, { at, corner }: Met): number {
  const distance = (vertex: number) =>
    Math.hypot(...at.map((value, i) => value - positions[3 * vertex + i]!));
  const corners = [0, 1, 2].map((i) => triangles[corner + i]!);
  return corners.reduce((best, one) => (distance(one) < distance(best) ? one : best));
}

export function vertexAt({ positions, origin }: Mesh, vertex: number): Point {
  return origin.map((value, i) => value + positions[3 * vertex + i]!) as unknown as Point;
}

/** Normals by area, the same on both sides of a seam of the texture. */
function normalsOf(p: Float32Array, triangles: Uint32Array, sources: Uint32Array) {
  const sums = new Float32Array(3 * (sources.reduce((most, one) => Math.max(most, one), 0) + 1));
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = [3 * triangles[i]!, 3 * triangles[i + 1]!, 3 * triangles[i + 2]!];
    const ux = p[b]! - p[a]!, uy = p[b + 1]! - p[a + 1]!, uz = p[b + 2]! - p[a + 2]!;
    const vx = p[c]! - p[a]!, vy = p[c + 1]! - p[a + 1]!, vz = p[c + 2]! - p[a + 2]!;
    const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (let k = 0; k < 3; k += 1) {
      const to = 3 * sources[triangles[i + k]!]!;
      for (let axis = 0; axis < 3; axis += 1) sums[to + axis]! += normal[axis]!;
    }
  }
  const normals = new Float32Array(p.length);
  sources.forEach((source, vertex) => normals.set(sums.subarray(3 * source, 3 * source + 3), 3 * vertex));
  return normals;
}

function boxOf(p: Float32Array, triangles: Uint32Array): { low: Point; high: Point } {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const vertex of triangles) {
    for (let axis = 0; axis < 3; axis += 1) {
      const value = p[3 * vertex + axis]!;
      if (value < low[axis]!) low[axis] = value;
      if (value > high[axis]!) high[axis] = value;
    }
  }
  return { low: low as never, high: high as never };
}
