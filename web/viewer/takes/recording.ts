// A take as a recording: what its file held, with what was edited since.
import { frameRate } from '../rig/clips';
import { HEAD_ANGLES } from '../rig/head';
import type { Clip, Recording } from '../types/model';

type Column = ArrayLike<number>;

/** Other sliders than the take has been matched to find their weights in it. */
export function recordingOf(clip: Clip): Recording {
  const columns = clip.recorded ? recordedColumns(clip, clip.recorded) : ownColumns(clip);
  const [names, table] = [[...columns.keys()], [...columns.values()]];
  const weights = Float64Array.from(
    { length: clip.times.length * names.length },
    (_, i) => table[i % names.length]![Math.floor(i / names.length)]!,
  );
  const timecodes = clip.recorded?.timecodes ?? [];
  return { names, times: clip.times, weights, rate: frameRate(clip), timecodes };
}

/** The mean of some columns of a recording, a frame. */
export function trackOf(
  { names, times, weights }: Recording,
  by: readonly string[],
): Float32Array<ArrayBuffer> {
  const columns = by.map((name) => names.indexOf(name));
  return Float32Array.from({ length: times.length }, (_, frame) =>
    columns.reduce((sum, j) => sum + weights[frame * names.length + j]! / columns.length, 0),
  );
}

function ownColumns({ tracks, heads }: Clip): Map<string, Column> {
  const found = [...tracks].map(([slider, track]) => [slider, Array.from(track, shortest)] as const);
  const angles = HEAD_ANGLES.map(
    (name, axis) => [name, (heads ?? []).map((head) => head[axis]!)] as const,
  );
  return new Map(heads ? [...found, ...angles] : found);
}

/** What its own columns cannot say of sliders follows in columns of their names. */
function recordedColumns(
  { tracks }: Clip,
  recorded: NonNullable<Clip['recorded']>,
): Map<string, Column> {
  const { names, weights, drives, times } = recorded;
  const moved = new Map(
    [...tracks].map(([slider, track]) => {
      const before = trackOf(recorded, drives.get(slider) ?? []);
      return [slider, track.map((value, i) => value - before[i]!)] as const;
    }),
  );
  const columns = names.map((name, j) => {
    const column = Float64Array.from(times, (_, i) => weights[i * names.length + j]!);
    const changes = [...moved].filter(([slider]) => drives.get(slider)?.includes(name));
    for (let i = 0; i < times.length; i += 1) {
      const by = changes.reduce((sum, [, change]) => sum + change[i]! / changes.length, 0);
      if (by !== 0) column[i] = shortest(column[i]! + by);
    }
    return column;
  });
  const found = new Map<string, Column>(names.map((name, j) => [name, columns[j]!]));
  for (const [slider, track] of tracks) {
    const by = (drives.get(slider) ?? []).map((name) => found.get(name)!);
    const back = (i: number) => by.reduce((sum, column) => sum + column[i]! / by.length, 0);
    const same = (value: number, i: number) => Math.abs(value - Math.fround(back(i))) < 1e-6;
    if (found.has(slider) || track.every(same)) continue;
    found.set(slider, Array.from(track, shortest));
  }
  return found;
}

/** The shortest number that stands for one of single precision. */
function shortest(value: number): number {
  const single = Math.fround(value);
  for (let digits = 6; digits < 9; digits += 1) {
    const text = Number(single.toPrecision(digits));
    if (Math.fround(text) === single) return text;
  }
  return single;
}
