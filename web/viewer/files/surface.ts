// All meshes of a file as one: vertices, triangles, and what the morph targets move.
import { shapesInOne } from '../rig/layout';
import { countOf, floats, floatsInto, indices } from './accessors';
import { isEntry, objectIn, type Entry, type GltfDocument } from './document';
import type { PlacedMesh } from './nodes';
import { mirrors, place, placeEach, type Placement } from './placing';
import { shownCoordinates } from './skins';
import { heldBy } from './skins_at_rest';

/** Triangles of one primitive, of all vertices of the file. */
export interface Piece {
  readonly triangles: Uint32Array;
  readonly material: number | null;
  readonly group: string; // name of its node
  readonly fans: boolean; // whether those of one polygon share their first corner
  readonly mirrored: boolean; // whether they are wound against the file, as the mesh is mirrored
}

export interface Surface {
  readonly neutral: Float32Array; // (V, 3)
  readonly normals: Float32Array | null; // (V, 3) of the neutral, where all meshes have them
  readonly uv: readonly Float32Array[]; // (V, 2) the sets of texture coordinates that images ask for
  readonly colours: Uint8Array | null; // (V, 4) of vertices, linear, where a mesh has any
  readonly pieces: readonly Piece[];
  readonly targetNames: readonly string[];
  readonly targets: readonly Float32Array[]; // (V, 3) each, in one stretch of memory
  readonly sheets: readonly number[]; // vertices in each of the sets that were put together
}

/** Vertices that one or several primitives share. */
interface Sheet {
  readonly start: number;
  readonly count: number;
  readonly primitive: Entry;
  readonly held: Placement | Float32Array; // where all its vertices are, or each of them: (V, 12)
  readonly targetNames: readonly string[];
}

const TRIANGLES = 4;
const STRIP = 5;
const FAN = 6;

export function readSurface(file: GltfDocument, meshes: readonly PlacedMesh[]): Surface {
  const sheets: Sheet[] = [];
  const pieces: Piece[] = [];
  for (const placed of meshes) readMesh(file, placed, sheets, pieces);
  const last = sheets.at(-1);
  if (!last || pieces.every(({ triangles }) => triangles.length === 0)) {
    file.refuse(
      'there is no face in it: no mesh with triangles. Export the mesh with its morph targets.',
    );
  }
  const vertices = last.start + last.count;
  const names = [...new Set(sheets.flatMap(({ targetNames }) => targetNames))];
  file.spend(4 * 3 * vertices * (names.length + 2));
  const neutral = new Float32Array(3 * vertices);
  const normals = sheets.every((s) => attribute(s, 'NORMAL') !== undefined)
    ? new Float32Array(3 * vertices)
    : null;
  const targets = shapesInOne(names.length, vertices);
  const numberOf = new Map(names.map((name, i) => [name, i]));
  for (const sheet of sheets) {
    const part = (shape: Float32Array) =>
      shape.subarray(3 * sheet.start, 3 * (sheet.start + sheet.count));
    fill(file, attribute(sheet, 'POSITION'), sheet, 'positions', part(neutral));
    if (normals) fill(file, attribute(sheet, 'NORMAL'), sheet, 'directions', part(normals));
    const moves = file.list(sheet.primitive, 'targets') as Entry[];
    sheet.targetNames.forEach((name, i) => {
      const displacement = moves[i]?.['POSITION'];
      if (displacement === undefined) return;
      fill(file, displacement, sheet, 'directions', part(targets[numberOf.get(name)!]!));
    });
  }
  requireFinite(file, neutral, 'the vertices');
  targets.forEach((target, i) => requireFinite(file, target, `the morph target '${names[i]}'`));
  const uv = textureCoordinates(file, sheets, vertices);
  const colours = coloursOf(file, sheets, vertices);
  const counts = sheets.map(({ count }) => count);
  return { neutral, normals, uv, colours, pieces, targetNames: names, targets, sheets: counts };
}

function readMesh(file: GltfDocument, placed: PlacedMesh, sheets: Sheet[], pieces: Piece[]): void {
  const mesh = file.item('meshes', placed.mesh, 'a node');
  const names = targetNamesOf(file, mesh);
  const shared = new Map<string, Sheet>();
  for (const primitive of file.list(mesh, 'primitives')) {
    if (!isEntry(primitive) || !isEntry(primitive['attributes']))
      file.damaged('a primitive has no attributes');
    const mode = Number(primitive['mode'] ?? TRIANGLES);
    if (mode < TRIANGLES || mode > FAN) continue; // points and lines are no surface
    const key = JSON.stringify([primitive['attributes'], primitive['targets']]);
    let sheet = shared.get(key);
    if (!sheet) {
      const position = primitive['attributes']['POSITION'];
      if (position === undefined) file.damaged(`the mesh '${placed.name}' has no positions`);
      const before = sheets.at(-1);
      const count = countOf(file, position, 'positions');
      const { joints, placement } = placed;
      sheet = {
        start: before ? before.start + before.count : 0,
        count,
        primitive,
        held: joints ? heldBy(file, primitive['attributes'], count, joints) : placement,
        targetNames: names.slice(0, file.list(primitive, 'targets').length),
      };
      file.spend(12 * sheet.count);
      shared.set(key, sheet);
      sheets.push(sheet);
    }
    const material = typeof primitive['material'] === 'number' ? primitive['material'] : null;
    pieces.push({
      triangles: triangles(file, primitive, sheet, mode),
      material,
      group: placed.name,
      fans: mode === TRIANGLES && 'FB_ngon_encoding' in objectIn(primitive, 'extensions'),
      mirrored: isMirrored(sheet),
    });
  }
}

function textureCoordinates(
  file: GltfDocument,
  sheets: readonly Sheet[],
  vertices: number,
): Float32Array[] {
  const names = sheets.map((sheet) => shownCoordinates(file, sheet.primitive));
  return [0, 1].flatMap((set) => {
    const own = sheets.map((sheet, i) => attribute(sheet, names[i]![set] ?? ''));
    if (own.every((accessor) => accessor === undefined)) return [];
    file.spend(8 * vertices);
    const uv = new Float32Array(2 * vertices);
    sheets.forEach(({ start, count }, i) => {
      const part = uv.subarray(2 * start, 2 * (start + count));
      if (own[i] !== undefined) floatsInto(file, own[i], 2, 'texture coordinates', part);
    });
    return [uv];
  });
}

/** Of vertices, with their opacity; white where a mesh has none, null where all are white. */
function coloursOf(
  file: GltfDocument,
  sheets: readonly Sheet[],
  vertices: number,
): Uint8Array | null {
  if (sheets.every((sheet) => attribute(sheet, 'COLOR_0') === undefined)) return null;
  file.spend(4 * vertices);
  const colours = new Uint8Array(4 * vertices).fill(255);
  for (const sheet of sheets) {
    const accessor = attribute(sheet, 'COLOR_0');
    if (accessor === undefined) continue;
    const width = file.item('accessors', accessor, 'colours')['type'] === 'VEC3' ? 3 : 4;
    const own = floats(file, accessor, width, 'colours', sheet.count);
    for (let i = 0; i < own.length; i += 1) {
      const at = 4 * (sheet.start + Math.floor(i / width)) + (i % width);
      colours[at] = Math.round(255 * Math.min(Math.max(own[i]!, 0), 1));
    }
  }
  return colours.every((part) => part === 255) ? null : colours;
}

function attribute(sheet: Sheet, name: string): unknown {
  return (sheet.primitive['attributes'] as Entry)[name];
}

/**
 * Names of the morph targets, each different from the others of its mesh. Most programs name them in
 * the extras of the mesh, some in those of each primitive, and older ones in those of each target:
 * the package takes them from the same places.
 */
export function targetNamesOf(file: GltfDocument, mesh: Entry): string[] {
  const primitives = file.list(mesh, 'primitives').filter(isEntry);
  const targets = primitives.map((primitive) => file.list(primitive, 'targets'));
  const lists = [
    ...[mesh, ...primitives].map((holder) => objectIn(holder, 'extras')['targetNames']),
    ...targets.map((own) => own.map((t) => isEntry(t) && objectIn(t, 'extras')['name'])),
  ];
  const isText = (name: unknown) => typeof name === 'string';
  const given = lists.filter(Array.isArray).find((own: unknown[]) => own.some(isText)) ?? [];
  const names: string[] = [];
  for (let i = 0; i < Math.max(0, ...targets.map((own) => own.length)); i += 1) {
    const name = typeof given[i] === 'string' ? (given[i] as string) : `target_${i}`;
    let own = name;
    for (let n = 2; names.includes(own); n += 1) own = `${name}_${n}`;
    names.push(own);
  }
  return names;
}

function fill(
  file: GltfDocument,
  accessor: unknown,
  { held, count }: Sheet,
  kind: 'positions' | 'directions',
  out: Float32Array,
): void {
  if (countOf(file, accessor, kind) === count) floatsInto(file, accessor, 3, kind, out);
  else out.set(floats(file, accessor, 3, kind, count));
  if (held instanceof Float32Array) placeEach(out, held, kind);
  else place(out, held, kind);
}

function triangles(file: GltfDocument, primitive: Entry, sheet: Sheet, mode: number): Uint32Array {
  const listed = primitive['indices'];
  if (listed === undefined) file.spend(4 * sheet.count);
  const corners =
    listed === undefined
      ? Uint32Array.from({ length: sheet.count }, (_, i) => i)
      : indices(file, listed, 'triangles');
  const found =
    mode === TRIANGLES
      ? corners.subarray(0, corners.length - (corners.length % 3))
      : unrolled(corners, mode);
  const flip = isMirrored(sheet);
  for (let i = 0; i < found.length; i += 1) {
    if (found[i]! >= sheet.count)
      file.damaged(`a triangle names vertex ${found[i]} of ${sheet.count}`);
    found[i]! += sheet.start;
    if (flip && i % 3 === 2) [found[i - 1], found[i]] = [found[i]!, found[i - 1]!];
  }
  return found;
}

function isMirrored({ held }: Sheet): boolean {
  return mirrors(held instanceof Float32Array ? [...held.subarray(0, 12)] : held);
}

function unrolled(corners: Uint32Array, mode: number): Uint32Array {
  const found = new Uint32Array(3 * Math.max(0, corners.length - 2));
  for (let i = 0; i + 2 < corners.length; i += 1) {
    const first = mode === FAN ? 0 : i;
    const [second, third] = mode === STRIP && i % 2 === 1 ? [i + 2, i + 1] : [i + 1, i + 2];
    found.set([corners[first]!, corners[second]!, corners[third]!], 3 * i);
  }
  return found;
}

function requireFinite(file: GltfDocument, values: Float32Array, what: string): void {
  let sum = 0;
  for (let i = 0; i < values.length; i += 1) sum += values[i]! * 0; // 0, or NaN for ever
  if (sum !== 0) file.damaged(`${what} contain numbers that are not finite`);
}
