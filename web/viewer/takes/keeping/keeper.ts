// Takes with their edits and sounds are there again when a page with the same rig is loaded.
import { numberOf, numbersByName } from '../../../shared/named';
import { grouped } from '../../files/container';
import { freshName } from '../../interface/poses/list';
import { keyOf } from '../../interface/state/kept';
import type { Store } from '../../interface/state/store';
import type { Clip, Scene } from '../../types/model';
import type { ViewState } from '../../types/state';
import { inFile, isInFile } from '../carrying';
import { carried } from '../reading';
import { span } from '../../rig/clips';
import type { Speaker } from '../sound';
import { dropped, type Entry, kept, keptSound, type Label, takesOf } from './entries';
import { inTime } from './shelf';

const SOON = 400; // milliseconds after a change that it is written
const LARGEST = 2 ** 28; // bytes of a sound

const FULL =
  'The storage of this browser is full, so takes last until this page is closed: save them as CSV, ' +
  'or close some.';
const FORBIDDEN =
  'This browser keeps no takes for this page, so they last until it is closed: save them as CSV.';
const DAMAGED =
  'A take that the browser kept for this rig is damaged; it was laid aside: open its file again.';

export interface Keeper {
  /** What is kept for a scene that is about to be shown. */
  of(scene: Scene, start: Partial<ViewState>): Promise<FoundTakes>;
  /** Whether the browser has a take as it is. */
  holds(take: Clip): boolean;
}

interface FoundTakes {
  /** Takes and how far their sounds are set off; those of the scene itself come first. */
  readonly fields: Pick<ViewState, 'takes' | 'soundOffsets'>;
  /** The scene is shown: from now on its takes are kept. */
  begin(): void;
}

type Shelf = Map<string, Entry>; // by the name that a take has on the page

/** @param tell hears why nothing can be kept, once, and what is damaged or too large. */
export function createKeeper(store: Store, speaker: Speaker, tell: (words: string) => void): Keeper {
  const shelves = new Map<string, Shelf>(); // what this page knows, by rig
  const scenes = new WeakSet<Clip>(); // takes that pages were made with
  let [rig, sliders, shelf]: [string, string, Shelf] = ['', '', new Map()];
  let timer: ReturnType<typeof setTimeout> | undefined;
  let queue: Promise<unknown> = Promise.resolve();
  let waiting = false;
  let told = false;

  const failed = (problem: unknown) => {
    if (told) return;
    told = true;
    tell((problem as DOMException | null)?.name === 'QuotaExceededError' ? FULL : FORBIDDEN);
  };
  const writeAll = async () => {
    const [key, own, on, { soundOffsets }] = [rig, shelf, sliders, store.get()];
    const takes = store.get().takes.filter((take) => !scenes.has(take));
    for (const [name, entry] of [...own]) {
      if (takes.some((take) => take.name === name)) continue;
      await dropped(key, entry).then(() => own.delete(name), failed);
    }
    for (const take of takes) {
      const { name } = take;
      const label = { name, filed: isInFile(take), offset: numberOf(soundOffsets, name), sliders: on };
      const sound = speaker.of(name)?.file ?? own.get(name)?.sound ?? null; // it may be on its way
      await keepOne(key, own, take, label, sound, tell).catch(failed);
    }
  };
  // While one is under way there is one more at most, of what there is by then.
  const write = () => {
    clearTimeout(timer);
    timer = undefined;
    if (!rig || waiting) return;
    waiting = true;
    queue = queue.then(() => {
      waiting = false;
      return writeAll();
    });
  };
  const soon = () => {
    if (rig) timer ??= setTimeout(write, SOON);
  };
  store.subscribe((state, before) => {
    if (state.takes !== before.takes || state.soundOffsets !== before.soundOffsets) soon();
  });
  speaker.subscribe(soon);
  addEventListener('visibilitychange', () => document.hidden && timer !== undefined && write());

  const found = async (key: string, { models }: Scene, start: Partial<ViewState>) => {
    const known = shelves.get(key);
    const own: Shelf = known ?? new Map<string, Entry>();
    const given = start.takes ?? [];
    const names = models[start.shown?.[0] ?? 0]?.sliders ?? [];
    const offsets = numbersByName();
    let takes = [...given];
    // What this page has shown of the rig before goes on with it, or is closed.
    const [entries, damaged] = known ? [[], 0] : await inTime(takesOf(key));
    if (damaged > 0) tell(DAMAGED);
    for (const entry of entries) {
      if (entry.filed && takes.some(({ name }) => name === entry.name)) {
        await dropped(key, entry).catch(() => undefined); // the same file
        continue;
      }
      takes = takes.filter((take) => take.name !== entry.name || !given.includes(take));
      const name = freshName(takes, entry.name);
      const fits = entry.sliders === names.join('\n');
      const take = { ...(fits ? entry.take : carried(entry.take, names)), name };
      if (entry.filed) inFile(take);
      takes.push(take);
      own.set(name, { ...entry, name, ...(fits && { take }) }); // else it is written anew
      if (entry.offset) offsets[name] = entry.offset;
    }
    return { own, names, takes, offsets };
  };

  return {
    holds: (take) => shelf.get(take.name)?.take === take,
    async of(scene, start) {
      if (timer !== undefined) write(); // for the scene before
      for (const take of start.takes ?? []) {
        inFile(take);
        scenes.add(take);
      }
      const key = keyOf(scene);
      await inTime(queue).catch(() => undefined); // faces open also where nothing is written
      const none = { own: null, names: [], takes: start.takes ?? [], offsets: {} };
      const { own, names, takes, offsets } = await found(key, scene, start).catch(() => none);
      return {
        fields: { takes, soundOffsets: { ...start.soundOffsets, ...offsets } },
        begin() {
          [rig, sliders, shelf] = [key, names.join('\n'), own ?? new Map<string, Entry>()];
          if (own) shelves.set(key, own);
          for (const { name, take, sound } of shelf.values()) {
            const before = speaker.of(name);
            // While it is read people may add another one, or open another face.
            const awaited = () => speaker.of(name) === before && shelf.get(name)?.sound === sound;
            if (sound && before?.file !== sound)
              speaker.read(sound).then(
                (buffer) => awaited() && speaker.lend(name, span(take)[0], sound, buffer),
                (problem: unknown) => tell((problem as Error).message),
              );
          }
          soon(); // those that have come along
        },
      };
    },
  };
}

async function keepOne(
  rig: string,
  own: Shelf,
  take: Clip,
  label: Label,
  sound: File | null,
  tell: (words: string) => void,
): Promise<void> {
  const { name } = take;
  let entry = own.get(name);
  const same = entry?.take === take && entry.offset === label.offset;
  if (!same) own.set(name, (entry = await kept(rig, take, label, entry)));
  if (entry!.sound === sound) return;
  const large = sound !== null && sound.size > LARGEST;
  if (large)
    tell(
      `${sound.name} has ${grouped(Math.ceil(sound.size / 2 ** 20))} MiB; sounds of up to ` +
        `${LARGEST / 2 ** 20} MiB are there again when the page is loaded, so add it again then.`,
    );
  await keptSound(rig, entry!, large ? null : sound);
  own.set(name, { ...entry!, sound });
}
