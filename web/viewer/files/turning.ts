// The turn of a head in glTF, as elastomorph.io.gltf.turning: a rotation of the bone that VRM calls the
// head, or of a node that is called so.
import { Euler, Matrix4, Quaternion, Vector3 } from 'three';
import type { Head } from '../types/model';
import { isEntry, type Entry, type GltfDocument } from './document';
import { rootOf, transform } from './nodes';
import { product, type Placement } from './placing';

const NAMED = /^(.*[^a-z])?head$/i;
const TURN = 2 * Math.PI;

/** Which of some nodes is the head. */
export function headNode(file: GltfDocument, among: readonly number[]): number | undefined {
  const bone = headBone(file.value('extensions'));
  const named = (number: number) => {
    const node = file.item('nodes', number, 'a node');
    // A mesh that joints hold, such as "Wolf3D_Head", stays where they are when its node turns.
    return NAMED.test(String(node['name'])) && node['skin'] === undefined;
  };
  return among.find((node) => (bone === undefined ? named(node) : node === bone));
}

function headBone(extensions: unknown): unknown {
  const under = (...keys: string[]) =>
    keys.reduce((at, key) => (isEntry(at) ? at[key] : undefined), extensions);
  const older = under('VRM', 'humanoid', 'humanBones');
  if (!Array.isArray(older)) return under('VRMC_vrm', 'humanoid', 'humanBones', 'head', 'node');
  return older.filter(isEntry).find(({ bone }) => bone === 'head')?.['node'];
}

/** How a node rests: all that it hangs below, as seen in the scene, and itself in that. */
export interface Rest {
  readonly above: Quaternion;
  readonly own: Quaternion;
}

export function restOf(file: GltfDocument, number: number): Rest {
  const parents = new Map<unknown, number>();
  file.items('nodes').forEach((node, parent) => {
    if (isEntry(node)) file.list(node, 'children').forEach((child) => parents.set(child, parent));
  });
  const own = transform(file, file.item('nodes', number, 'a node'));
  let above: Placement | null = null;
  const seen = new Set([number]);
  for (let at = parents.get(number); at !== undefined && !seen.has(at); at = parents.get(at)) {
    seen.add(at);
    const outer = transform(file, file.item('nodes', at, 'a node'));
    above = above ? product(outer, above) : outer;
  }
  const root = rootOf(file);
  return { above: rotationIn(above ? product(root, above) : root), own: rotationIn(own) };
}

function rotationIn(m: Placement): Quaternion {
  const [a, b, c, d, e, f, g, h, i] = m as number[] as [
    ...[number, number, number],
    ...[number, number, number],
    ...[number, number, number],
  ];
  const turned = new Quaternion();
  new Matrix4()
    .set(a, d, g, 0, b, e, h, 0, c, f, i, 0, 0, 0, 0, 1)
    .decompose(new Vector3(), turned, new Vector3());
  return turned;
}

/** Yaw, pitch and roll of a node that has a rotation in its parent. */
export function anglesOf({ above, own }: Rest, rotation: Quaternion): Head {
  const seen = above.clone().multiply(rotation).multiply(own.clone().invert());
  const { x, y, z } = new Euler().setFromQuaternion(seen.multiply(above.clone().invert()), 'YXZ');
  return [-y, x, -z];
}

/** Of all angles that turn alike those near the ones before, so that what lies between is between. */
export function continuous(heads: readonly Head[]): Head[] {
  let last = heads[0]!;
  const nearest = (angle: number, axis: number) =>
    angle - TURN * Math.round((angle - last[axis]!) / TURN);
  const near = (head: Head) => head.map(nearest) as unknown as Head;
  const way = (head: Head) => Math.hypot(...head.map((angle, axis) => angle - last[axis]!));
  return heads.map(([yaw, pitch, roll]) => {
    const one = near([yaw, pitch, roll]);
    const other = near([yaw + Math.PI, Math.PI - pitch, roll + Math.PI]);
    last = way(other) < way(one) ? other : one;
    return last;
  });
}

/** The nodes a head may be: bones, and what hangs others in a place of its own. */
export function mayTurn(file: GltfDocument): number[] {
  const skins = file.items('skins').filter(isEntry);
  const known = new Set(skins.flatMap((skin) => file.list(skin, 'joints')));
  return file.items('nodes').flatMap((node, number) => {
    const own = node as Entry;
    const holds = known.has(number) || (own['children'] && own['translation']);
    return holds && own['matrix'] === undefined ? number : [];
  });
}
