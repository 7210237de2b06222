// Takes as files: what was recorded, and as a clip of the sliders of one rig.
import { grouped, refuse } from '../files/container';
import { openFile } from '../files/open';
import { performances } from '../rig/clips';
import type { Clip, Recording } from '../types/model';
import { readColumns } from './csv/columns';
import { isLiveLink, readLiveLink } from './csv/livelink';
import { readTable } from './csv/table';
import { matched, type Drives } from './matching';
import { isRotation } from './names';
import { readNpz } from './npz';
import { recordingOf, trackOf } from './recording';

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
  if (/\.(gl(b|tf)|vrm)$/i.test(name)) return performanceIn(name, bytes);
  const table = readTable(name, bytes);
  return isLiveLink(table) ? readLiveLink(table) : readColumns(table);
}

/** The first performance of a rig in a file, as if it were recorded. */
async function performanceIn(name: string, bytes: ArrayBuffer): Promise<Recording> {
  const clip = performances([await openFile(name, bytes)])[0];
  if (!clip)
    refuse(name, 'there is no performance in it. Export it with its animation of weights.');
  return recordingOf(clip);
}

/** A recording on the sliders of a rig. */
function clipOf(file: string, recording: Recording, sliders: readonly string[]): Clip {
  const clip = driven(nameOf(file), recording, matching(file, recording.names, sliders));
  const [beyond] = [...clip.tracks].find(([, track]) => !track.every(Number.isFinite)) ?? [];
  if (beyond !== undefined)
    refuse(file, `what drives ${beyond} has numbers beyond any weight. Correct them.`);
  return clip;
}

/** A take for the sliders of another rig, with what was edited; it may drive none of them. */
export function carried(clip: Clip, sliders: readonly string[]): Clip {
  const recording = recordingOf(clip);
  let drives: Drives = new Map();
  try {
    drives = matched(recording.names, sliders);
  } catch {
    // Two names of one meaning: it waits for a rig of its own.
  }
  return driven(clip.name, recording, drives);
}

function driven(name: string, recording: Recording, drives: Drives): Clip {
  const tracks = new Map([...drives].map(([slider, by]) => [slider, trackOf(recording, by)]));
  return { name, times: recording.times, tracks, recorded: { ...recording, drives } };
}

/** A file without its suffix; one that is called by its suffix alone is a take all the same. */
export function nameOf(file: string): string {
  return file.replace(/\.\w+$/, '') || 'take';
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
