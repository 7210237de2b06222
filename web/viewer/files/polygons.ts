// The polygons that the triangles of a file were, as elastomorph describes them in its extras: fans
// of triangles, one after another within each part.
import { shapesInOne } from '../rig/layout';
import { isEntry, type Entry } from './document';
import { unpacked } from './packed';
import type { Piece, Surface } from './surface';

export interface Polygons {
  /** (V,) the vertex each vertex is a copy of, or itself. */
  readonly seams: Uint32Array;
  /** Polygon of each triangle, by piece. */
  readonly ofTriangle: readonly Uint32Array[];
  /** Name of the group of each polygon; null where there are none. */
  readonly groups: { readonly names: readonly string[]; readonly ofPolygon: Int32Array } | null;
  readonly edges: Uint32Array;
}

/**
 * A surface whose materials are meshes of their own, with its vertices in the order it was written
 * in; as it is, where its meshes are not those that the first of them describes.
 */
export async function inOne(surface: Surface, stored: readonly Entry[]): Promise<Surface> {
  const whole = stored[0]?.['whole'];
  const { sheets, neutral } = surface;
  if (!isEntry(whole) || whole['parts'] !== stored.length || sheets.length !== stored.length)
    return surface;
  const total = whole['vertices'];
  const parts = stored.map(({ part }) => (isEntry(part) ? part : {}));
  const rows = await Promise.all(parts.map((part, i) => unpacked(part['vertices'], sheets[i]!)));
  const places = rows.flatMap((own) => [...(own ?? [])]);
  const fits =
    isCount(total, neutral.length / 3) &&
    parts.every((part, i) => part['number'] === i) &&
    rows.every((own) => own) &&
    places.every((v) => v >= 0 && v < total) &&
    new Set(places).size === total;
  if (!fits) return surface;
  const arranged = (from: Float32Array, width: number, filled?: Float32Array): Float32Array => {
    const into = filled ?? new Float32Array(width * total);
    places.forEach((place, v) => {
      for (let i = 0; i < width; i += 1) into[width * place + i] ||= from[width * v + i]!;
    });
    return into;
  };
  const targets = shapesInOne(surface.targets.length, total);
  surface.targets.forEach((target, i) => arranged(target, 3, targets[i]));
  return {
    ...surface,
    neutral: arranged(neutral, 3),
    normals: surface.normals && arranged(surface.normals, 3),
    uv: surface.uv.map((own) => arranged(own, 2)),
    colours: null,
    pieces: surface.pieces.map((piece) => ({
      ...piece,
      triangles: piece.triangles.map((v) => places[v]!),
    })),
    targets,
    sheets: [total],
  };
}

/** The polygons described in `extras.elastomorph.model.surface`, or null where they do not fit. */
export async function readPolygons(stored: unknown, surface: Surface): Promise<Polygons | null> {
  if (!isEntry(stored) || surface.sheets.length !== 1) return null;
  const { vertices, polygons } = stored;
  const total = surface.neutral.length / 3;
  const triangles = surface.pieces.reduce((sum, piece) => sum + piece.triangles.length / 3, 0);
  if (!isCount(vertices, total) || !isCount(polygons, triangles)) return null;
  const [copies, sizes, materials, groups] = await Promise.all([
    unpacked(stored['copies'], total - vertices),
    unpacked(stored['sizes'], polygons),
    labels(stored['materials'], polygons),
    labels(stored['groups'], polygons),
  ]);
  if (!copies || !sizes || !copies.every((v) => v >= 0 && v < vertices)) return null;
  const seams = Uint32Array.from({ length: total }, (_, v) =>
    v < vertices ? v : copies[v - vertices]!,
  );
  const ofTriangle = polygonsOfTriangles(
    stored['parts'],
    surface,
    sizes,
    materials?.ofPolygon ?? null,
  );
  if (!ofTriangle) return null;
  const edges = polygonEdges(surface, ofTriangle, seams);
  return { seams, ofTriangle, groups, edges };
}

function polygonsOfTriangles(
  parts: unknown,
  surface: Surface,
  sizes: Int32Array,
  material: Int32Array | null,
): Uint32Array[] | null {
  const pieces = surface.pieces.filter(({ triangles }) => triangles.length > 0);
  if (!Array.isArray(parts) || parts.length !== pieces.length) return null;
  const found = surface.pieces.map(({ triangles }) => new Uint32Array(triangles.length / 3));
  for (const [number, label] of parts.entries()) {
    const own = found[surface.pieces.indexOf(pieces[number]!)]!;
    let place = 0;
    for (let p = 0; p < sizes.length; p += 1) {
      if ((material?.[p] ?? -1) !== label) continue;
      const fan = sizes[p]! - 2;
      if (fan < 1 || place + fan > own.length) return null;
      own.fill(p, place, place + fan);
      place += fan;
    }
    if (place !== own.length) return null;
  }
  return found;
}

/** Edges (E, 2) between original vertices, each once, without the diagonals of the fans. */
function polygonEdges(
  surface: Surface,
  ofTriangle: readonly Uint32Array[],
  seams: Uint32Array,
): Uint32Array {
  const keys: number[] = [];
  surface.pieces.forEach(({ triangles, mirrored }, number) => {
    const polygon = ofTriangle[number]!;
    const [second, third] = mirrored ? [2, 1] : [1, 2]; // as the file winds them
    for (let t = 0; t < polygon.length; t += 1) {
      const [a, b, c] = [triangles[3 * t]!, triangles[3 * t + second]!, triangles[3 * t + third]!];
      keys.push(edgeKey(b, c, seams));
      if (polygon[t] !== polygon[t - 1]) keys.push(edgeKey(a, b, seams));
      if (polygon[t] !== polygon[t + 1]) keys.push(edgeKey(c, a, seams));
    }
  });
  return edgesOf(keys);
}

/** Edges (E, 2) where nothing is described: of triangles, or of the polygons their fans encode. */
export function plainEdges(surface: Surface, seams: Uint32Array): Uint32Array {
  return polygonEdges(surface, surface.pieces.map(fansOf), seams);
}

/**
 * FB_ngon_encoding: triangles of one polygon follow each other and have the same first corner. Those
 * that do not lie on the one before begin another, and so do all of a fan that comes to a corner
 * again, as in the package.
 */
function fansOf({ triangles, fans, mirrored }: Piece): Uint32Array {
  const [second, third] = mirrored ? [2, 1] : [1, 2];
  const polygon = Uint32Array.from({ length: triangles.length / 3 }, (_, t) => t);
  let corners = new Set<number>();
  let closed = false;
  for (let [t, start] = [0, 0]; fans && t < polygon.length; t += 1) {
    const [from, before] = [3 * t, 3 * t - 3];
    const same =
      t > 0 &&
      triangles[from] === triangles[before] &&
      triangles[from + second] === triangles[before + third];
    if (!same) {
      [start, closed, corners] = [t, false, new Set([triangles[from + second]!])];
    }
    if (!closed && corners.has(triangles[from + third]!)) {
      closed = true;
      for (let own = start; own < t; own += 1) polygon[own] = own;
    }
    corners.add(triangles[from + third]!);
    if (!closed) polygon[t] = start;
  }
  return polygon;
}

const SHIFT = 2 ** 26; // two vertex numbers in one whole number below 2⁵³

function edgeKey(one: number, other: number, seams: Uint32Array): number {
  const [a, b] = [seams[one]!, seams[other]!];
  return a < b ? a * SHIFT + b : b * SHIFT + a;
}

function edgesOf(keys: readonly number[]): Uint32Array {
  const sorted = Float64Array.from(keys).sort();
  const found = new Uint32Array(2 * sorted.length);
  let length = 0;
  for (let i = 0; i < sorted.length; i += 1) {
    if (i > 0 && sorted[i] === sorted[i - 1]) continue;
    found[length] = Math.floor(sorted[i]! / SHIFT);
    found[length + 1] = sorted[i]! % SHIFT;
    length += 2;
  }
  return found.slice(0, length);
}

async function labels(stored: unknown, polygons: number): Promise<Polygons['groups']> {
  if (!isEntry(stored)) return null;
  const names = (stored as Entry)['names'];
  const ofPolygon = await unpacked(stored['of_polygon'], polygons);
  if (!Array.isArray(names) || !ofPolygon) return null;
  return { names: names.map(String), ofPolygon };
}

function isCount(value: unknown, most: number): value is number {
  return typeof value === 'number' && Number.isInteger(value) && value >= 0 && value <= most;
}
