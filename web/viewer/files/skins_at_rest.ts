// Where the joints of a skin hold vertices at rest.
import { floats } from './accessors';
import type { Entry, GltfDocument } from './document';
import { product, UNIT, type Placement } from './placing';

const ALIKE = 1e-4; // single precision, through a chain of joints
const SETS = 8; // of four joints each, more than any program writes

/** What each joint of a skin does to the vertices it holds alone. */
export function jointsOf(
  file: GltfDocument,
  skin: unknown,
  world: (node: number) => Placement,
): Placement[] {
  const entry = file.item('skins', skin, 'a node');
  const joints = file.list(entry, 'joints') as number[];
  if (joints.length === 0) file.damaged('a skin has no joints');
  const given = entry['inverseBindMatrices'];
  if (given === undefined) return joints.map(world);
  const bound = floats(file, given, 16, 'the inverse bind matrices');
  if (bound.length < 16 * joints.length) file.damaged('a skin has too few matrices');
  return joints.map((joint, j) => {
    const own = [0, 1, 2, 4, 5, 6, 8, 9, 10, 12, 13, 14].map((i) => bound[16 * j + i]!);
    return product(world(joint), own);
  });
}

/** Where a primitive's vertices are held: (V, 12), or one placement where all are held alike. */
export function heldBy(
  file: GltfDocument,
  attributes: Entry,
  count: number,
  joints: readonly Placement[],
): Placement | Float32Array {
  const common = alike(joints);
  if (common) return common;
  file.spend(48 * count);
  const held = new Float32Array(12 * count);
  const totals = new Float32Array(count);
  for (let set = 0; set < SETS && `JOINTS_${set}` in attributes; set += 1) {
    const numbers = floats(file, attributes[`JOINTS_${set}`], 4, 'the joints', count);
    const weights = floats(file, attributes[`WEIGHTS_${set}`], 4, 'the weights', count);
    for (let i = 0; i < 4 * count; i += 1) {
      const weight = weights[i]!;
      if (!(weight > 0)) continue;
      const joint = joints[numbers[i]!] ?? file.damaged('a vertex is held by no joint of its skin');
      const vertex = i >> 2;
      totals[vertex]! += weight;
      for (let k = 0; k < 12; k += 1) held[12 * vertex + k]! += weight * joint[k]!;
    }
  }
  for (let v = 0; v < count; v += 1) {
    const total = totals[v]!;
    for (let k = 0; k < 12; k += 1)
      held[12 * v + k] = total > 0 ? held[12 * v + k]! / total : UNIT[k]!;
  }
  return held;
}

/** The placement that all are to rounding, exactly the unit where they are that. */
function alike(joints: readonly Placement[]): Placement | null {
  const first = joints[0] ?? UNIT;
  const apart = ALIKE * Math.max(1, ...first.map(Math.abs));
  const near = (one: Placement, other: Placement) =>
    one.every((value, k) => Math.abs(value - other[k]!) <= apart);
  if (!joints.every((joint) => near(joint, first))) return null;
  return near(first, UNIT) ? UNIT : first;
}
