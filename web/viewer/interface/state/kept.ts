// What the browser keeps of the work on a rig until the page is opened again.
import type { Scene } from '../../types/model';
import type { NamedPose, ViewState } from '../../types/state';
import { added, freshName } from '../poses/list';
import { understood } from './checked';
import type { History } from './history';
import { merged } from './merging';
import type { Store } from './store';

const SOON = 400; // milliseconds after a change that it is written

const FULL =
  'The storage of this browser is full, so poses last until this page is closed: save them as JSON.';
const FORBIDDEN =
  'This browser keeps nothing for this page, so poses last until it is closed: save them as JSON.';

/** What is put together from all pages that show the rig. */
type Lists = Pick<ViewState, 'poses' | 'favourites' | 'folded'>;
const NOTHING: Lists = { poses: [], favourites: [], folded: [] };

interface Record extends Lists {
  readonly start: string; // what the page was asked to begin with
  readonly view: string; // as in an address
}

export interface Kept {
  /** What is kept for a scene that is about to be shown with a start. */
  of(scene: Scene, start: Partial<ViewState>): Found;
}

interface Found {
  readonly lists: Lists;
  readonly view: string; // the last one, where the page is asked for the same start; else ''
  /** The scene is shown: from now on its work is kept. */
  begin(): void;
}

/**
 * @param view the present view as words, '' where none is to be kept.
 * @param tell hears why nothing can be kept, once.
 */
export function createKept(
  store: Store,
  history: History,
  view: () => string,
  tell: (problem: string) => void,
): Kept {
  let key = '';
  let start = '';
  let base: Lists = NOTHING; // what all pages had in common when this one looked last
  let timer: ReturnType<typeof setTimeout> | undefined;
  let told = false;

  const problem = (words: string) => {
    if (!told && JSON.stringify(listsOf(store.get())) !== JSON.stringify(NOTHING)) {
      told = true;
      tell(words);
    }
  };
  // Throws where the browser forbids it.
  const read = (key: string): Record | null => {
    const text = localStorage.getItem(key);
    if (text === null) return null;
    try {
      return recordIn(text);
    } catch {
      localStorage.setItem(`${key} damaged`, text);
      localStorage.removeItem(key);
      tell('What the browser kept for this rig is damaged; it was laid aside, and the page begins anew.');
      return null;
    }
  };
  const join = (theirs: Lists) => {
    const from = base;
    if (JSON.stringify(theirs) !== JSON.stringify(from))
      history.amend((fields) => mergedLists(from, fields, theirs));
    base = theirs;
  };
  const write = () => {
    clearTimeout(timer);
    timer = undefined;
    if (!key) return;
    try {
      const theirs = read(key);
      if (theirs) join(listsOf(theirs));
      base = listsOf(store.get());
      const record: Record = { start, view: view(), ...base };
      localStorage.setItem(key, JSON.stringify({ version: 1, ...record }));
    } catch (error) {
      const full = error instanceof DOMException && error.name === 'QuotaExceededError';
      problem(full ? FULL : FORBIDDEN);
    }
  };
  store.subscribe((state, before) => {
    const fields = Object.keys(NOTHING) as (keyof Lists)[];
    const made = fields.some((field) => state[field] !== before[field]);
    const moving = state.playing || state.live; // its end is written
    if (key && (made || !moving)) timer ??= setTimeout(write, SOON);
  });
  addEventListener('pagehide', write);
  addEventListener('visibilitychange', () => document.hidden && write());
  addEventListener('storage', (event) => {
    if (!key || event.key !== key || event.newValue === null) return;
    try {
      join(listsOf(recordIn(event.newValue)));
    } catch {
      // Whoever wrote that is told of it.
    }
  });

  return {
    of(scene, given) {
      if (timer !== undefined) write(); // for the scene before
      const [ownKey, ownStart] = [keyOf(scene), JSON.stringify(scene.start)];
      let record: Record | null = null;
      try {
        record = read(ownKey);
      } catch {
        // Told when there is something that is lost.
      }
      const asked = listsOf({ ...NOTHING, ...given });
      const held = record ? listsOf(record) : NOTHING;
      const again = record?.start === ownStart;
      const together = {
        poses: added(held.poses, asked.poses),
        favourites: [...new Set([...held.favourites, ...asked.favourites])],
        folded: record ? held.folded : asked.folded,
      };
      return {
        lists: again ? held : together,
        view: again ? record!.view : '',
        begin: () => ([key, start, base] = [ownKey, ownStart, held]),
      };
    },
  };
}

/** A rig is known by its title, its vertices and the names of its sliders. */
function keyOf({ title, models }: Scene): string {
  const [model] = models;
  const names = model?.sliders.join('\n') ?? '';
  let sum = 0x811c9dc5; // FNV-1a
  for (const letter of names) sum = Math.imul(sum ^ letter.codePointAt(0)!, 0x01000193) >>> 0;
  return `elastomorph ${title}, ${(model?.neutral.length ?? 0) / 3}, ${sum.toString(36)}`;
}

/** @throws Error where the text was not written by this page. */
function recordIn(text: string): Record {
  const found = JSON.parse(text) as Record;
  const { poses, favourites, folded } = found;
  const refuse = (problem: string) => {
    throw new Error(problem);
  };
  const lists = { ...NOTHING, ...understood({ poses, favourites, folded }, refuse) };
  return { ...lists, start: String(found.start ?? ''), view: String(found.view ?? '') };
}

function listsOf({ poses, favourites, folded }: Lists): Lists {
  return { poses, favourites, folded };
}

function mergedLists(base: Lists, mine: Partial<ViewState>, theirs: Lists): Partial<ViewState> {
  const names = (field: 'favourites' | 'folded') => {
    const own = mine[field];
    return own && { [field]: merged(base[field], own, theirs[field], (one) => one, (one) => one) };
  };
  const anew = (pose: NamedPose, others: readonly NamedPose[]) => ({
    ...pose,
    name: freshName(others, pose.name),
  });
  const poses =
    mine.poses && merged(base.poses, mine.poses, theirs.poses, ({ name }) => name, anew);
  return { ...mine, ...(poses && { poses }), ...names('favourites'), ...names('folded') };
}
