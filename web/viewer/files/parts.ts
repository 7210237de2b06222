// The triangles of a file, sorted into parts that look alike.
import type { Part, Skin } from '../types/model';
import { componentsOf } from './components';
import { isEntry, type GltfDocument } from './document';
import { eyeOf } from './eyes';
import { linear, LOOKS, partOfName, type PartKind } from './looks';
import type { Polygons } from './polygons';
import { PLAIN } from './skins';
import type { Piece, Surface } from './surface';

export interface SortedParts {
  readonly triangles: Uint32Array;
  readonly parts: readonly Part[];
}

type Colour = readonly [number, number, number];

interface Label {
  readonly name: string;
  readonly kind: PartKind;
  readonly colour: Colour;
  readonly eye?: NonNullable<Part['eye']>;
}

/** Parts by the names and colours of materials, else of the groups of polygons, else of nodes. */
export function sortedParts(
  file: GltfDocument,
  surface: Surface,
  polygons: Polygons | null,
  seams: Uint32Array,
): SortedParts {
  const total = surface.pieces.reduce((sum, { triangles }) => sum + triangles.length, 0);
  const all = new Uint32Array(total);
  const labels: Label[] = [];
  const ofTriangle = new Uint32Array(total / 3);
  const numbers = new Map<string, number>();
  const numberOf = (label: Label, key: string) => {
    if (!numbers.has(key)) numbers.set(key, labels.push(label) - 1);
    return numbers.get(key)!;
  };
  let place = 0;
  surface.pieces.forEach((piece, number) => {
    all.set(piece.triangles, place);
    const material = materialOf(file, piece);
    const polygon = polygons?.ofTriangle[number];
    for (let t = 0; t < piece.triangles.length / 3; t += 1) {
      const group = polygons?.groups
        ? polygons.groups.names[polygons.groups.ofPolygon[polygon?.[t] ?? -1] ?? -1]
        : piece.group;
      const key = `${number}/${group}`;
      ofTriangle[place / 3 + t] = numbers.get(key) ?? numberOf(labelOf(material, group), key);
    }
    place += piece.triangles.length;
  });
  const component = componentsOf(all, seams);
  attachShells(all, ofTriangle, labels, component);
  drawIrises(surface.neutral, all, ofTriangle, labels, component);
  return gathered(all, ofTriangle, labels);
}

/** Parts by material, of a file that says how each of them looks; what blends comes last. */
export function dressedParts(
  file: GltfDocument,
  surface: Surface,
  skins: readonly Skin[],
): SortedParts {
  const materials = [...new Set(surface.pieces.map(({ material }) => material))];
  const skinOf = (material: number | null) => skins[material ?? -1] ?? PLAIN;
  const order = ({ opacity, rank }: Skin) => (opacity === 'blend' ? rank : -Infinity);
  materials.sort((a, b) => order(skinOf(a)) - order(skinOf(b)) || 0);
  const total = surface.pieces.reduce((sum, piece) => sum + piece.triangles.length, 0);
  const triangles = new Uint32Array(total);
  const parts: Part[] = [];
  let place = 0;
  for (const material of materials) {
    const start = place;
    const pieces = surface.pieces.filter((piece) => piece.material === material);
    for (const piece of pieces) {
      triangles.set(piece.triangles, place);
      place += piece.triangles.length;
    }
    const { name } = materialOf(file, pieces[0]!);
    const skin = skinOf(material);
    const [r, g, b] = skin.colour;
    const part = { name: name || pieces[0]!.group, start, count: place - start };
    if (part.count > 0) parts.push({ ...part, colour: [r, g, b], shine: 0, shown: true, skin });
  }
  return { triangles, parts };
}

function labelOf(
  { name, colour }: { name: string; colour: Colour | null },
  group: string | undefined,
): Label {
  const byMaterial = partOfName(name);
  // A material may say only "skin" or "default" where the group says "teeth".
  const kind = byMaterial === 'skin' ? partOfName(group ?? '') : byMaterial;
  const ofGroup = kind !== byMaterial || !name;
  return {
    name: ofGroup ? (group ?? name) : name,
    kind,
    colour: colour ?? linear(LOOKS[kind].colour),
  };
}

/** Name and colour of a material; null for white, grey or an image, which say nothing here. */
function materialOf(file: GltfDocument, piece: Piece): { name: string; colour: Colour | null } {
  if (piece.material === null) return { name: '', colour: null };
  const material = file.item('materials', piece.material, 'a primitive');
  const name = typeof material['name'] === 'string' ? material['name'] : '';
  const shading = material['pbrMetallicRoughness'];
  if (!isEntry(shading) || shading['baseColorTexture'] !== undefined) return { name, colour: null };
  const [r, g, b] = file.numbers(shading, 'baseColorFactor', 4, [1, 1, 1, 1]) as [
    number,
    number,
    number,
    number,
  ];
  const telling = Math.max(r, g, b) - Math.min(r, g, b) > 0.02 || Math.max(r, g, b) < 0.4;
  return { name, colour: telling ? [r, g, b] : null };
}

/** What is called a shell but is sewn to the face is skin; lashes that float are a shell. */
function attachShells(
  all: Uint32Array,
  ofTriangle: Uint32Array,
  labels: Label[],
  component: Uint32Array,
): void {
  for (const [kind, attached] of [
    ['hidden', 'skin'],
    ['lash', 'lash'],
  ] as const) {
    const others = new Set<number>();
    const doubtful: number[] = [];
    ofTriangle.forEach((label, t) => {
      if (labels[label]!.kind === kind) doubtful.push(t);
      else others.add(component[all[3 * t]!]!);
    });
    const numbers = new Map<string, number>();
    for (const t of doubtful) {
      const label = labels[ofTriangle[t]!]!;
      const becomes: PartKind = others.has(component[all[3 * t]!]!) ? attached : 'hidden';
      if (becomes === label.kind) continue;
      const key = `${ofTriangle[t]}/${becomes}`;
      if (!numbers.has(key))
        numbers.set(
          key,
          labels.push({ name: label.name, kind: becomes, colour: linear(LOOKS[becomes].colour) }) -
            1,
        );
      ofTriangle[t] = numbers.get(key)!;
    }
  }
}

function drawIrises(
  neutral: Float32Array,
  all: Uint32Array,
  ofTriangle: Uint32Array,
  labels: Label[],
  component: Uint32Array,
): void {
  const shells = new Map<number, number[]>();
  const inner: number[] = [];
  ofTriangle.forEach((label, t) => {
    const { kind } = labels[label]!;
    if (kind === 'iris' || kind === 'pupil')
      inner.push(all[3 * t]!, all[3 * t + 1]!, all[3 * t + 2]!);
    if (kind !== 'sclera') return;
    const piece = component[all[3 * t]!]!;
    if (!shells.has(piece)) shells.set(piece, []);
    shells.get(piece)!.push(t);
  });
  for (const triangles of shells.values()) {
    const vertices = triangles.flatMap((t) => [all[3 * t]!, all[3 * t + 1]!, all[3 * t + 2]!]);
    const eye = eyeOf(neutral, vertices, inner);
    if (!eye) continue;
    const number = labels.push({ ...labels[ofTriangle[triangles[0]!]!]!, eye }) - 1;
    for (const t of triangles) ofTriangle[t] = number;
  }
}

/** The triangles of each label one after another. */
function gathered(
  all: Uint32Array,
  ofTriangle: Uint32Array,
  labels: readonly Label[],
): SortedParts {
  const counts = new Uint32Array(labels.length);
  for (const label of ofTriangle) counts[label]! += 3;
  const parts: Part[] = [];
  const places = new Uint32Array(labels.length);
  let start = 0;
  labels.forEach(({ name, kind, colour, eye }, number) => {
    const count = counts[number]!;
    places[number] = start;
    if (count > 0) {
      parts.push({
        name: name || kind,
        start,
        count,
        colour,
        shine: LOOKS[kind].shine,
        shown: kind !== 'hidden',
        ...(eye && { eye }),
      });
    }
    start += count;
  });
  const triangles = new Uint32Array(all.length);
  ofTriangle.forEach((label, t) => {
    triangles.set(all.subarray(3 * t, 3 * t + 3), places[label]!);
    places[label]! += 3;
  });
  return { triangles, parts };
}
