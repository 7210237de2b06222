// Animations of morph target weights, as performances of sliders.
import type { Clip, Corrective, Morph } from '../types/model';
import { floats } from './accessors';
import { isEntry, type Entry, type GltfDocument } from './document';
import type { PlacedMesh } from './nodes';
import { targetNamesOf } from './surface';

interface Channel {
  readonly times: Float32Array;
  readonly weights: Float32Array; // (keys, targets)
  readonly names: readonly string[];
  readonly step: boolean;
}

/**
 * The performances of a file. Clips that play one path from end to end, as elastomorph writes one
 * for each morph, are not: the sliders do that.
 */
export function readClips(
  file: GltfDocument,
  placed: readonly PlacedMesh[],
  targetNames: readonly string[],
  morphs: readonly Morph[],
  correctives: readonly Corrective[],
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
    const clip = clipOf(name, channels, targetNames, morphs, correctives);
    const moving = [...clip.tracks.keys()];
    const playsOne = moving.length === 1 && moving[0] === name;
    if (moving.length > 0 && !playsOne) clips.push(clip);
  });
  return clips;
}

function channel(
  file: GltfDocument,
  animation: Entry,
  entry: Entry,
  ofNode: ReadonlyMap<unknown, number>,
): Channel | null {
  const target = entry['target'];
  if (!isEntry(target) || target['path'] !== 'weights') return null;
  const number = ofNode.get(target['node']);
  const samplers = file.list(animation, 'samplers');
  const sampler = samplers[Number(entry['sampler'])];
  if (number === undefined || !isEntry(sampler)) return null;
  const mesh = file.item('meshes', number, 'an animation');
  const primitive = file.list(mesh, 'primitives')[0];
  const names = isEntry(primitive) ? targetNamesOf(file, mesh, primitive) : [];
  if (names.length === 0) return null;
  const times = floats(file, sampler['input'], 1, 'times of keys');
  const cubic = sampler['interpolation'] === 'CUBICSPLINE';
  const values = floats(file, sampler['output'], 1, 'weights of keys');
  const per = names.length * (cubic ? 3 : 1);
  if (values.length !== times.length * per || times.length === 0) return null;
  // Of a spline, its keys: between them a performance is drawn straight.
  const weights = cubic
    ? Float32Array.from(
        { length: times.length * names.length },
        (_, i) => values[Math.floor(i / names.length) * per + names.length + (i % names.length)]!,
      )
    : values;
  return { times, weights, names, step: sampler['interpolation'] === 'STEP' };
}

function clipOf(
  name: string,
  channels: readonly Channel[],
  targetNames: readonly string[],
  morphs: readonly Morph[],
  correctives: readonly Corrective[],
): Clip {
  const times = Float32Array.from(new Set(channels.flatMap((c) => [...c.times]))).sort();
  const tau = new Map<string, Float32Array>();
  for (const { name: morph, delta, fold } of morphs) {
    const target = targetNames[delta]!;
    const source = channels.find(({ names }) => names.includes(target));
    if (!source) continue;
    const track = resampled(source, source.names.indexOf(target), times);
    tau.set(morph, fold ? track.map((weight) => unfolded(weight, fold)) : track);
  }
  const tracks = new Map<string, Float32Array>();
  for (const [morph, track] of tau) {
    const corrective = correctives.find((c) => c.name === morph);
    if (corrective && !corrective.drivers.includes(morph)) continue;
    const own = corrective ? undriven(track, corrective, tau) : track;
    if (own.some((weight) => weight !== 0)) tracks.set(morph, own);
  }
  return { name, times, tracks };
}

/** The time of a path at which its target has a weight, by bisection. */
function unfolded(weight: number, fold: (t: number) => number): number {
  if (weight === 0) return 0; // to the last bit, so that what is at rest counts as such
  let low = -8;
  let high = 8;
  for (let step = 0; step < 40; step += 1) {
    const middle = (low + high) / 2;
    if (fold(middle) < weight) low = middle;
    else high = middle;
  }
  return (low + high) / 2;
}

/** The slider of a corrective that others drive with it: its weight over the product of theirs. */
function undriven(
  track: Float32Array,
  { name, drivers }: Corrective,
  tau: ReadonlyMap<string, Float32Array>,
): Float32Array {
  return track.map((weight, i) => {
    const others = drivers
      .filter((d) => d !== name)
      .reduce((product, d) => product * (tau.get(d)?.[i] ?? 0), 1);
    return Math.abs(others) > 1e-6 ? weight / others : 0;
  });
}

function resampled(
  { times, weights, names, step }: Channel,
  column: number,
  at: Float32Array,
): Float32Array {
  const value = (key: number) => weights[key * names.length + column] ?? 0;
  let key = 0;
  return at.map((time) => {
    while (key < times.length - 1 && times[key + 1]! <= time) key += 1;
    const span = (times[key + 1] ?? 0) - times[key]!;
    if (step || key === times.length - 1 || time <= times[key]! || span <= 0) return value(key);
    return value(key) + ((time - times[key]!) / span) * (value(key + 1) - value(key));
  });
}
