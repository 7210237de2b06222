// Takes as files: what was recorded, and as a clip of the sliders of one rig.
import { grouped, refuse } from '../files/container';
import { openFile } from '../files/open';
import { frameRate, performances } from '../rig/clips';
import type { Clip, Recording } from '../types/model';
import { readColumns } from './csv/columns';
import { isLiveLink, readLiveLink } from './csv/livelink';
import { readTable } from './csv/table';
import { matched, type Drives } from './matching';
import { isRotation } from './names';
import { readNpz } from './npz';

export const TAKES = /\.(csv|npz)$/i;
const LARGEST = 2 ** 27; // bytes: about three hours of a phone

/**
 * The take in a file, for these sliders.
 *
 * @throws Error with a sentence that names the file and what to do
 */
export async function readTake(file: File, sliders: readonly string[]): Promise<Clip> {
  const { name, size } = file;
  if (size > LARGEST && TAKES.test(name))
    refuse(
      name,
      `it has ${grouped(Math.ceil(size / 2 ** 20))} MiB; takes of up to ${LARGEST / 2 ** 20} MiB are ` +
        'opened here. Cut it into parts.',
    );
  return clipOf(name, await recordingIn(name, await file.arrayBuffer()), sliders);
}

async function recordingIn(name: string, bytes: ArrayBuffer): Promise<Recording> {
  if (/\.npz$/i.test(name)) return readNpz(name, bytes);
  if (/\.gl(b|tf)$/i.test(name)) return recordingOf(name, bytes);
  const table = readTable(name, bytes);
  return isLiveLink(table) ? readLiveLink(table) : readColumns(table);
}

/** The first performance of a rig in a file, as if it were recorded. */
async function recordingOf(name: string, bytes: ArrayBuffer): Promise<Recording> {
  const clip = performances([await openFile(name, bytes)])[0];
  if (!clip)
    refuse(name, 'there is no performance in it. Export it with its animation of weights.');
  const names = [...clip.tracks.keys()];
  const tracks = [...clip.tracks.values()];
  const times = Float64Array.from(clip.times);
  const weights = Float64Array.from(
    { length: times.length * names.length },
    (_, i) => tracks[i % names.length]![Math.floor(i / names.length)]!,
  );
  return { names, times, weights, rate: frameRate(clip), timecodes: [] };
}

/** A recording on the sliders of a rig. */
export function clipOf(file: string, recording: Recording, sliders: readonly string[]): Clip {
  const drives = matching(file, recording.names, sliders);
  const { names, weights } = recording;
  const times = Float32Array.from(recording.times);
  const back = times.findIndex((time, i) => i > 0 && time <= times[i - 1]!);
  if (back >= 0)
    refuse(
      file,
      `frames ${grouped(back - 1)} and ${grouped(back)} are too close in time (${recording.times[back]} s) ` +
        'to be told apart. Let the take begin near 0 s.',
    );
  const tracks = new Map<string, Float32Array>();
  for (const [slider, by] of drives) tracks.set(slider, trackOf(names, weights, times.length, by));
  return { name: file.replace(/\.\w+$/, ''), times, tracks, recorded: { ...recording, drives } };
}

/** The mean of some columns of a recording, a frame. */
export function trackOf(
  names: readonly string[],
  weights: Float64Array,
  frames: number,
  by: readonly string[],
): Float32Array {
  const columns = by.map((name) => names.indexOf(name));
  return Float32Array.from({ length: frames }, (_, frame) =>
    columns.reduce((sum, j) => sum + weights[frame * names.length + j]! / columns.length, 0),
  );
}

function matching(file: string, names: readonly string[], sliders: readonly string[]): Drives {
  let drives: Drives;
  try {
    drives = matched(names, sliders);
  } catch (problem) {
    return refuse(file, `${(problem as Error).message}.`);
  }
  if (drives.size > 0) return drives;
  return refuse(
    file,
    `no weight drives a slider of this rig: the take has ${few(names)}, the rig ` +
      `${few(sliders) || 'no sliders'}. Open the take's own rig, or rename its columns.`,
  );
}

function few(names: readonly string[]): string {
  const more = names.length > 3 ? ', …' : '';
  return names.slice(0, 3).join(', ') + more;
}

/** What a take drives and what is left over, for people. */
export function matchWords({ recorded, tracks }: Clip, sliders: readonly string[]): string {
  if (!recorded) return `${tracks.size} of ${sliders.length} sliders move`;
  const weights = recorded.names.filter((name) => !isRotation(name));
  const used = new Set([...recorded.drives.values()].flat());
  const left = weights.filter((name) => !used.has(name));
  const still = sliders.filter((slider) => !recorded.drives.has(slider));
  const lines = [
    `${used.size} of ${weights.length} weights drive ${recorded.drives.size} of ${sliders.length} sliders`,
  ];
  if (left.length > 0) lines.push(`not on the rig: ${left.join(', ')}`);
  if (still.length > 0) lines.push(`not driven: ${still.join(', ')}`);
  return lines.join('\n');
}
