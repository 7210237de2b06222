// Which meshes a document shows, and where: nodes, their order and their transforms.
import { isEntry, type Entry, type GltfDocument } from './document';

/** Twelve numbers: what x, y and z are multiplied with, then what is added; by columns. */
export type Placement = readonly number[];

export interface PlacedMesh {
  readonly node: number; // -1 for a mesh that no node shows
  readonly mesh: number;
  readonly name: string;
  readonly placement: Placement;
}

const UNIT: Placement = [1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];

/**
 * The meshes of the scene that is shown, depth first. A mesh with a skin stays where its vertices
 * are: it is at rest. A document that shows nothing gives all its meshes.
 */
export function placedMeshes(file: GltfDocument): PlacedMesh[] {
  const found: PlacedMesh[] = [];
  const seen = new Set<number>();
  const waiting = roots(file)
    .reverse()
    .map((node) => [node, UNIT] as const);
  for (let next = waiting.pop(); next; next = waiting.pop()) {
    const [number, above] = next;
    const node = file.item('nodes', number, 'the scene');
    if (seen.has(number)) file.damaged(`node ${number} appears twice in the scene`);
    seen.add(number);
    const world = product(above, transform(file, node));
    if (node['mesh'] !== undefined) {
      found.push(placed(file, number, node, node['skin'] === undefined ? world : UNIT));
    }
    const children = file.list(node, 'children') as number[];
    waiting.push(...[...children].reverse().map((child) => [child, world] as const));
  }
  if (found.length > 0) return found;
  return file.items('meshes').map((_, mesh) => placed(file, -1, { mesh }, UNIT));
}

function placed(file: GltfDocument, number: number, node: Entry, placement: Placement): PlacedMesh {
  const mesh = file.item('meshes', node['mesh'], 'a node');
  const name = [node['name'], mesh['name']].find((text) => typeof text === 'string');
  return {
    node: number,
    mesh: node['mesh'] as number,
    name: name ?? `mesh ${node['mesh']}`,
    placement,
  };
}

function roots(file: GltfDocument): number[] {
  const scenes = file.items('scenes');
  if (scenes.length > 0) {
    return [
      ...file.list(file.item('scenes', file.value('scene') ?? 0, 'the document'), 'nodes'),
    ] as number[];
  }
  const nodes = file.items('nodes');
  const below = new Set(
    nodes.flatMap((node) => (isEntry(node) ? file.list(node, 'children') : [])),
  );
  return nodes.map((_, number) => number).filter((number) => !below.has(number));
}

function transform(file: GltfDocument, node: Entry): Placement {
  if (node['matrix'] !== undefined) {
    const m = file.numbers(node, 'matrix', 16, []);
    return [0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14].map((i) => m[i]!);
  }
  const [x, y, z, w] = file.numbers(node, 'rotation', 4, [0, 0, 0, 1]) as [
    number,
    number,
    number,
    number,
  ];
  const [a, b, c] = file.numbers(node, 'scale', 3, [1, 1, 1]) as [number, number, number];
  const moved = file.numbers(node, 'translation', 3, [0, 0, 0]);
  return [
    a * (1 - 2 * (y * y + z * z)),
    a * 2 * (x * y + z * w),
    a * 2 * (x * z - y * w),
    b * 2 * (x * y - z * w),
    b * (1 - 2 * (x * x + z * z)),
    b * 2 * (y * z + x * w),
    c * 2 * (x * z + y * w),
    c * 2 * (y * z - x * w),
    c * (1 - 2 * (x * x + y * y)),
    ...moved,
  ];
}

function product(outer: Placement, inner: Placement): Placement {
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
