// Which meshes a document shows, and where: nodes, their order and their transforms.
import { isEntry, type Entry, type GltfDocument } from './document';
import { AROUND, product, UNIT, type Placement } from './placing';
import { jointsOf } from './skins_at_rest';

export interface PlacedMesh {
  readonly node: number; // -1 for a mesh that no node shows
  readonly mesh: number;
  readonly name: string;
  readonly placement: Placement;
  /** What the joints of its skin do to its vertices at rest, in place of the placement. */
  readonly joints: readonly Placement[] | null;
}

/**
 * The meshes of the scene that is shown, depth first. A mesh with a skin stands where its joints hold
 * it at rest. A document that shows nothing gives all its meshes. Characters of VRM 0.x, which look
 * backwards, are turned around.
 */
export function placedMeshes(file: GltfDocument): PlacedMesh[] {
  const found: PlacedMesh[] = [];
  const worlds = new Map<number, Placement>();
  const skinned: Entry[] = [];
  const root = rootOf(file);
  const waiting = roots(file)
    .reverse()
    .map((node) => [node, root] as const);
  for (let next = waiting.pop(); next; next = waiting.pop()) {
    const [number, above] = next;
    const node = file.item('nodes', number, 'the scene');
    if (worlds.has(number)) file.damaged(`node ${number} appears twice in the scene`);
    const world = product(above, transform(file, node));
    worlds.set(number, world);
    if (node['mesh'] !== undefined) {
      found.push(placed(file, number, node, world));
      skinned.push(node);
    }
    const children = file.list(node, 'children') as number[];
    waiting.push(...[...children].reverse().map((child) => [child, world] as const));
  }
  // A joint may come after the mesh it holds, or lie outside the scene: there it stands by itself.
  const worldOf = (node: number) =>
    worlds.get(node) ?? product(root, transform(file, file.item('nodes', node, 'a skin')));
  if (found.length > 0)
    return found.map((mesh, i) => {
      const skin = skinned[i]!['skin'];
      return skin === undefined ? mesh : { ...mesh, joints: jointsOf(file, skin, worldOf) };
    });
  return file.items('meshes').map((_, mesh) => placed(file, -1, { mesh }, root));
}

function placed(file: GltfDocument, number: number, node: Entry, placement: Placement): PlacedMesh {
  const mesh = file.item('meshes', node['mesh'], 'a node');
  const name = [node['name'], mesh['name']].find((text) => typeof text === 'string');
  return {
    node: number,
    mesh: node['mesh'] as number,
    name: name ?? `mesh ${node['mesh']}`,
    placement,
    joints: null,
  };
}

/** In glTF, and VRM 1.0, what is shown looks along +Z; in VRM 0.x along −Z. */
export function rootOf(file: GltfDocument): Placement {
  const extensions = file.value('extensions');
  const backwards = isEntry(extensions) && 'VRM' in extensions && !('VRMC_vrm' in extensions);
  return backwards ? AROUND : UNIT;
}

export function roots(file: GltfDocument): number[] {
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

export function transform(file: GltfDocument, node: Entry): Placement {
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
