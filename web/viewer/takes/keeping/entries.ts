// Takes as entries of the browser's database, and back.
import { checked, isWhole } from '../../interface/state/checked';
import type { Clip } from '../../types/model';
import { answer, atShelf, type Key, numbers, PARTS, within } from './shelf';

const VERSION = 1;
const PIECE = 2 ** 17; // weights in one entry: a megabyte

/** What is said of a take apart from its numbers. */
export interface Label {
  readonly name: string;
  readonly filed: boolean; // whether people have it in a file
  readonly offset: number; // of its sound, in seconds
  readonly sliders: string; // of the rig that its curves are for
}

interface Head extends Label {
  readonly version: number;
  readonly at: number; // when it was kept first: their order
  readonly stamp: string; // of the page that wrote it, and when
  readonly tracks: readonly string[];
}

/** A take as the database has it, as far as this page knows. */
export interface Entry extends Label {
  readonly id: string;
  readonly at: number;
  readonly stamp: string;
  readonly take: Clip;
  readonly sound: File | null;
}

type Recorded = NonNullable<Clip['recorded']>;

/** What a take was opened with, but for the weights: of long ones they would hold up the page. */
interface Base extends Pick<Clip, 'times' | 'heads'> {
  readonly recorded?: Omit<Recorded, 'times' | 'weights' | 'timecodes'> & { readonly codes: string };
}

/** All takes of a rig in their order, and how many were damaged and are laid aside now. */
export async function takesOf(rig: string): Promise<readonly [Entry[], number]> {
  const found = await atShelf('readonly', async (entries) => {
    const keys = (await answer(entries.getAllKeys(within(rig)))) as Key[];
    const ids = [...new Set(keys.map(([, id]) => id))];
    return Promise.all(ids.map((id) => entryOf(entries, rig, id).catch(() => id)));
  });
  const damaged = found.filter((one) => typeof one === 'string');
  for (const id of damaged) await layAside(rig, id).catch(() => undefined); // it stays as it is
  const whole = found.filter((one) => typeof one !== 'string');
  return [whole.sort((a, b) => a.at - b.at), damaged.length];
}

async function entryOf(entries: IDBObjectStore, rig: string, id: string): Promise<Entry> {
  const part = (key: number | string) => answer<unknown>(entries.get([rig, id, key]));
  const head = (await part(PARTS.head)) as Head;
  const [base, sound, ...tracks] = (await Promise.all(
    [PARTS.base, PARTS.sound, ...head.tracks].map(part),
  )) as [Base, File | undefined, ...Float32Array[]];
  const pieces = (await answer(entries.getAll(numbers(rig, id, false)))) as Float64Array[];
  const recorded = base.recorded && recordedOf(base.times, base.recorded, pieces);
  const take: Clip = {
    name: head.name,
    times: base.times,
    ...(base.heads && { heads: base.heads }),
    tracks: new Map(head.tracks.map((slider, i) => [slider, tracks[i]!])),
    ...(recorded && { recorded }),
  };
  const typed = take.times instanceof Float64Array && tracks.every((t) => t instanceof Float32Array);
  const turns = !base.heads || base.heads.length === base.times.length;
  if (head.version !== VERSION || !head.name || !typed || !turns || !isWhole(take))
    throw new TypeError(id);
  checked({ takes: [take], soundOffsets: { [head.name]: head.offset } }); // else no page would open
  return { ...head, id, take, sound: sound instanceof Blob ? sound : null };
}

function recordedOf(
  times: Clip['times'],
  { codes, ...rest }: NonNullable<Base['recorded']>,
  pieces: readonly Float64Array[],
): Recorded {
  const weights = new Float64Array(rest.names.length * times.length);
  let place = 0;
  for (const piece of pieces) {
    weights.set(piece, place);
    place += piece.length;
  }
  const known = rest.drives instanceof Map && rest.rate > 0 && place === weights.length;
  if (!known || !weights.every(Number.isFinite)) throw new TypeError(codes);
  return { ...rest, times, weights, timecodes: codes ? codes.split('\n') : [] };
}

function layAside(rig: string, id: string): Promise<void> {
  return atShelf('readwrite', async (entries) => {
    const keys = (await answer(entries.getAllKeys(within(rig, id)))) as Key[];
    for (const key of keys) {
      const aside = [`${rig}, damaged`, ...key.slice(1)];
      await answer(entries.put(await answer(entries.get(key)), aside));
      await answer(entries.delete(key));
    }
  });
}

/**
 * Writes a take, or what of it is not as it was written last. Where another page has written the same
 * one since, that stays, and this is one more.
 */
export function kept(rig: string, take: Clip, label: Label, last?: Entry): Promise<Entry> {
  return atShelf('readwrite', async (entries) => {
    const there = last && (await standing(entries, rig, last.id));
    const mine = there !== undefined && there.stamp === last?.stamp;
    const id = last && (mine || !there) ? last.id : unique();
    const before = mine ? last.take : null;
    const onward = before?.times === take.times && before.recorded === take.recorded;
    if (!onward) {
      await answer(entries.delete(numbers(rig, id, true)));
      await answer(entries.put(baseOf(take), [rig, id, PARTS.base]));
    }
    // One after another: in between the page goes on.
    const weights = onward ? undefined : take.recorded?.weights;
    for (let start = 0, i = PARTS.weights; weights && start < weights.length; start += PIECE, i += 1)
      await answer(entries.put(weights.slice(start, start + PIECE), [rig, id, i]));
    for (const [slider, track] of take.tracks)
      if (!onward || before.tracks.get(slider) !== track)
        await answer(entries.put(track, [rig, id, slider]));
    const head: Head = {
      ...label,
      version: VERSION,
      at: last?.at ?? Date.now(),
      stamp: unique(),
      tracks: [...take.tracks.keys()],
    };
    await answer(entries.put(head, [rig, id, PARTS.head]));
    return { ...head, id, take, sound: mine ? last.sound : null };
  });
}

function baseOf({ times, heads, recorded }: Clip): Base {
  if (!recorded) return { times, ...(heads && { heads }) };
  const { weights: _, times: __, timecodes, ...rest } = recorded;
  return { times, recorded: { ...rest, codes: timecodes.join('\n') } };
}

/** Writes the sound of a take; null takes it away. */
export function keptSound(rig: string, { id }: Entry, sound: File | null): Promise<unknown> {
  return atShelf<unknown>('readwrite', (entries) => {
    const key = [rig, id, PARTS.sound];
    return sound ? answer(entries.put(sound, key)) : answer(entries.delete(key));
  });
}

/** Takes a take away, unless another page has written it since. */
export function dropped(rig: string, { id, stamp }: Entry): Promise<void> {
  return atShelf('readwrite', async (entries) => {
    const there = await standing(entries, rig, id);
    if (there?.stamp === stamp) await answer(entries.delete(within(rig, id)));
  });
}

function standing(entries: IDBObjectStore, rig: string, id: string) {
  return answer(entries.get([rig, id, PARTS.head])) as Promise<Head | undefined>;
}

function unique(): string {
  return `${Date.now()} ${Math.random()}`;
}
