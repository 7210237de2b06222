// Animations of morph target weights, as performances of sliders: as elastomorph.io.gltf.clips. A
// channel is played as glTF says, straight between keys, in steps or along splines; steps become a key
// just before the jump, splines as many as a player could tell apart.
import { Quaternion } from 'three';
import type { Clip, Model } from '../types/model';
import { floats } from './accessors';
import { isEntry, type Entry, type GltfDocument } from './document';
import type { PlacedMesh } from './nodes';
import { targetNamesOf } from './surface';
import { anglesOf, continuous, headNode, restOf, type Rest } from './turning';

const JUMP = 1e-4; // seconds before a jump, where the value before it ends
const BETWEEN = 8; // keys put into each stretch of a spline
const FARTHEST = 8; // time of a path
const HALVINGS = 40; // to the last bit of single precision

type Paths = Pick<Model, 'morphs' | 'bender'>;

interface Channel {
  readonly times: Float32Array;
  readonly values: Float32Array; // (keys, names), or (keys, 3, names) with tangents around them
  readonly names: readonly string[];
  readonly kind: string;
}

/**
 * The performances of a file. Clips that play one path from end to end, as elastomorph writes one
 * for each morph, are not: the sliders do that.
 */
export function readClips(
  file: GltfDocument,
  placed: readonly PlacedMesh[],
  targetNames: readonly string[],
  paths: Paths,
): Clip[] {
  const ofNode = new Map(placed.map((mesh) => [mesh.node, mesh.mesh]));
  const clips: Clip[] = [];
  file.items('animations').forEach((animation, number) => {
    if (!isEntry(animation)) return;
    const name =
      typeof animation['name'] === 'string' && animation['name']
        ? animation['name']
        : `clip ${number + 1}`;
    const channels = file
      .list(animation, 'channels')
      .filter(isEntry)
      .flatMap((entry) => channel(file, animation, entry, ofNode) ?? []);
    if (channels.length === 0) return;
    const turned = turnedHead(file, animation);
    const clip = clipOf(name, channels, targetNames, paths, turned);
    const moving = [...clip.tracks.keys()];
    const playsOne = moving.length === 1 && moving[0] === name;
    if (clip.heads || (moving.length > 0 && !playsOne)) clips.push(clip);
  });
  return clips;
}

function channel(
  file: GltfDocument,
  animation: Entry,
  entry: Entry,
  ofNode: ReadonlyMap<unknown, number>,
): Channel | null {
  const number = meshMoved(entry['target'], ofNode);
  if (number === undefined) return null;
  const mesh = file.item('meshes', number, 'an animation');
  return keysOf(file, animation, entry, targetNamesOf(file, mesh), 1);
}

/** The keys of a channel, one number a name, of so many in a row of the file. */
function keysOf(
  file: GltfDocument,
  animation: Entry,
  entry: Entry,
  names: readonly string[],
  width: number,
): Channel | null {
  const sampler = file.list(animation, 'samplers')[Number(entry['sampler'])];
  if (!isEntry(sampler)) return null;
  const times = floats(file, sampler['input'], 1, 'times of keys');
  const values = floats(file, sampler['output'], width, 'values of keys');
  const kind = String(sampler['interpolation'] ?? 'LINEAR');
  const count = times.length * names.length * (kind === 'CUBICSPLINE' ? 3 : 1);
  const rises = times.every((time, i) => time >= 0 && (i === 0 || time > times[i - 1]!));
  const sound = rises && times.every(Number.isFinite) && values.every(Number.isFinite);
  return count > 0 && values.length === count && sound ? { times, values, names, kind } : null;
}

const WEIGHTS = /^\/(nodes|meshes)\/(\d{1,9})\/weights$/;

/** The mesh whose weights a channel moves, by its node or by a pointer (KHR_animation_pointer). */
function meshMoved(
  target: unknown,
  ofNode: ReadonlyMap<unknown, number>,
): number | undefined {
  if (!isEntry(target)) return undefined;
  if (target['path'] === 'weights') return ofNode.get(target['node']);
  const { extensions } = target;
  const pointer = isEntry(extensions) && extensions['KHR_animation_pointer'];
  const found = WEIGHTS.exec(isEntry(pointer) ? String(pointer['pointer']) : '');
  if (target['path'] !== 'pointer' || !found) return undefined;
  return found[1] === 'meshes' ? Number(found[2]) : ofNode.get(Number(found[2]));
}

function clipOf(
  name: string,
  channels: readonly Channel[],
  targetNames: readonly string[],
  paths: Paths,
  turned: Turned | null,
): Clip {
  const moments = Float32Array.from(
    [...channels, ...(turned ? [turned.keys] : [])].flatMap(momentsOf),
    (time) => Math.max(0, time),
  );
  const times = Float64Array.from(new Set(moments)).sort();
  const tau = new Map<string, Float32Array>();
  for (const { name: morph, delta, fold } of paths.morphs) {
    const target = targetNames[delta]!;
    const source = channels.find(({ names }) => names.includes(target));
    if (!source) continue;
    const track = resampled(source, source.names.indexOf(target), times);
    tau.set(morph, fold ? track.map((weight) => unfolded(weight, fold)) : track);
  }
  const tracks = new Map<string, Float32Array>();
  for (const [morph, track] of tau) {
    const column = paths.bender.sliders.indexOf(morph);
    if (column < 0) continue;
    const own = undriven(track, column, paths, tau);
    if (own.some((weight) => weight !== 0)) tracks.set(morph, own);
  }
  const heads =
    turned && continuous(rotationsAt(turned.keys, times).map((at) => anglesOf(turned.rest, at)));
  const still = !heads?.some((head) => head.some((angle) => Math.abs(angle) > 1e-6));
  return { name, times, tracks, ...(!still && { heads: heads! }) };
}

/** How an animation turns the head. */
interface Turned {
  readonly keys: Channel; // quaternions
  readonly rest: Rest;
}

function turnedHead(file: GltfDocument, animation: Entry): Turned | null {
  const channels = file
    .list(animation, 'channels')
    .filter(isEntry)
    .flatMap((entry) => {
      const { target } = entry;
      const turns = isEntry(target) && target['path'] === 'rotation';
      return turns && typeof target['node'] === 'number' ? { node: target['node'], entry } : [];
    });
  const node = headNode(
    file,
    channels.map((one) => one.node),
  );
  const own = channels.find((one) => one.node === node);
  const keys = own && keysOf(file, animation, own.entry, [...'xyzw'], 4);
  return keys ? { keys, rest: restOf(file, own.node) } : null;
}

/** Rotations at (T,) times that rise: along arcs between keys that no spline joins. */
function rotationsAt(keys: Channel, at: Float64Array): Quaternion[] {
  const { times, values, names, kind } = keys;
  if (kind === 'STEP' || kind === 'CUBICSPLINE') {
    const parts = names.map((_, column) => resampled(keys, column, at));
    return Array.from(at, (_, i) =>
      new Quaternion().fromArray(parts.map((part) => part[i]!)).normalize(),
    );
  }
  const turned = (key: number) => new Quaternion().fromArray(values, 4 * key).normalize();
  let key = 0;
  return Array.from(at, (time) => {
    while (key < times.length - 2 && times[key + 1]! <= time) key += 1;
    if (times.length === 1) return turned(0);
    const share = (time - times[key]!) / (times[key + 1]! - times[key]!);
    return turned(key).slerp(turned(key + 1), Math.min(1, Math.max(0, share)));
  });
}

/** The time of a path at which its target has a weight. */
function unfolded(weight: number, fold: (t: number) => number): number {
  if (weight === 0) return 0; // to the last bit, so that what is at rest counts as such
  return bisected(weight < 0 ? -FARTHEST : 0, weight > 1 ? FARTHEST : 1, (t) => fold(t) < weight);
}

/** Where from low to high what is too low ends. */
function bisected(low: number, high: number, isLow: (middle: number) => boolean): number {
  for (let step = 0; step < HALVINGS; step += 1) {
    const middle = (low + high) / 2;
    if (isLow(middle)) low = middle;
    else high = middle;
  }
  return (low + high) / 2;
}

/**
 * The slider of a path from the weight of the path: of a corrective that others drive with it, what
 * gives it that weight, as Corrective.driven_by of the package.
 */
function undriven(
  track: Float32Array,
  column: number,
  { bender }: Paths,
  tau: ReadonlyMap<string, Float32Array>,
): Float32Array {
  const { sliders, morphs } = bender;
  const number = morphs.findIndex(({ name }) => name === sliders[column]);
  const { drivers, law } = morphs[number]!;
  const others = drivers.filter((driver) => driver !== column);
  if (others.length === 0 && law === 'product') return track;
  const tracks = sliders.map((slider) => tau.get(slider));
  return track.map((weight, i) => {
    const values = tracks.map((own) => own?.[i] ?? 0);
    if (law === 'product') {
      const rest = others.reduce((all, driver) => all * values[driver]!, 1);
      return Math.abs(rest) > 1e-6 ? weight / rest : 0;
    }
    if (weight === 0) return 0;
    return bisected(0, 1, (middle) => {
      values[column] = middle;
      return bender.times(values)[number]! < weight;
    });
  });
}

/** Times between which a channel is straight. */
function momentsOf({ times, kind }: Channel): number[] {
  const later = [...times.subarray(1)];
  if (kind === 'STEP') return [...times, ...later.map((time) => time - JUMP)];
  if (kind !== 'CUBICSPLINE') return [...times];
  return [...times].flatMap((time, i) => {
    const length = (times[i + 1] ?? time) - time;
    return Array.from({ length: length > 0 ? BETWEEN : 1 }, (_, k) => time + (k / BETWEEN) * length);
  });
}

/** The weight of one target at (T,) times that rise. */
function resampled(
  { times, values, names, kind }: Channel,
  column: number,
  at: Float64Array,
): Float32Array {
  const spline = kind === 'CUBICSPLINE';
  // Of a spline, the tangent before (0), the value (1) and the tangent after it (2).
  const value = (key: number, which = 1) =>
    values[(spline ? 3 * key + which : key) * names.length + column]!;
  let key = 0;
  return Float32Array.from(at, (time) => {
    while (key < times.length - 1 && times[key + 1]! <= time) key += 1;
    if (kind === 'STEP' || key === times.length - 1 || time <= times[key]!) return value(key);
    const length = times[key + 1]! - times[key]!;
    const s = (time - times[key]!) / length;
    const rise = value(key + 1) - value(key);
    if (!spline) return value(key) + s * rise;
    const [out, into] = [length * value(key, 2), length * value(key + 1, 0)];
    return value(key) + s * s * (3 - 2 * s) * rise + s * (1 - s) * ((1 - s) * out - s * into);
  });
}
