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
const FIELDS = Object.keys(NOTHING) as (keyof Lists)[];

/** The last view, beside the lists: while somebody drags a slider it is all that is written. */
interface Last {
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
  const unkept = new Map<string, Lists>(); // what the browser has not taken, by key

  const problem = (words: string) => {
    if (!told && JSON.stringify(listsOf(store.get())) !== JSON.stringify(NOTHING)) {
      told = true;
      tell(words);
    }
  };
  // Throws where the browser forbids it.
  const read = (key: string): Lists | null => {
    const text = localStorage.getItem(key);
    if (text === null) return null;
    try {
      return listsIn(text);
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
    unkept.set(key, listsOf(store.get()));
    try {
      if (FIELDS.some((field) => store.get()[field] !== base[field])) {
        const theirs = read(key);
        if (theirs) join(theirs);
        const own = listsOf(store.get());
        localStorage.setItem(key, JSON.stringify({ version: 1, ...own }));
        base = own;
      }
      unkept.delete(key);
      const last: Last = { start, view: view() };
      if (last.view) localStorage.setItem(viewOf(key), JSON.stringify(last));
    } catch (error) {
      const full = error instanceof DOMException && error.name === 'QuotaExceededError';
      problem(full ? FULL : FORBIDDEN);
    }
  };
  store.subscribe((state, before) => {
    const made = FIELDS.some((field) => state[field] !== before[field]);
    const moving = state.playing || state.live; // its end is written
    if (key && (made || !moving)) timer ??= setTimeout(write, SOON);
  });
  addEventListener('pagehide', write);
  addEventListener('visibilitychange', () => document.hidden && write());
  addEventListener('storage', (event) => {
    if (!key || event.key !== key || event.newValue === null) return;
    try {
      join(listsIn(event.newValue));
    } catch {
      // Whoever wrote that is told of it.
    }
  });

  return {
    of(scene, given) {
      if (timer !== undefined) write(); // for the scene before
      const [ownKey, ownStart] = [keyOf(scene), JSON.stringify(scene.start)];
      let [stored, last]: [Lists | null, Last | null] = [null, null];
      try {
        [stored, last] = [read(ownKey), lastIn(localStorage.getItem(viewOf(ownKey)))];
      } catch {
        // Told when there is something that is lost.
      }
      const found = unkept.get(ownKey) ?? stored;
      const asked = listsOf({ ...NOTHING, ...given });
      const held = found ?? NOTHING;
      const again = last?.start === ownStart;
      const together = {
        poses: added(held.poses, asked.poses),
        favourites: [...new Set([...held.favourites, ...asked.favourites])],
        folded: found ? held.folded : asked.folded,
      };
      return {
        lists: again && found ? held : together,
        view: again ? last!.view : '',
        begin: () => ([key, start, base] = [ownKey, ownStart, stored ?? NOTHING]),
      };
    },
  };
}

/** A rig is known by its name and its vertices; targets may come and go. */
export function keyOf({ name, models }: Scene): string {
  return `elastomorph ${name}, ${(models[0]?.neutral.length ?? 0) / 3}`;
}

function viewOf(key: string): string {
  return `${key}, view`;
}

/** @throws Error where the text was not written by this page. */
function listsIn(text: string): Lists {
  const { poses, favourites, folded } = JSON.parse(text) as Lists;
  const refuse = (problem: string) => {
    throw new Error(problem);
  };
  return { ...NOTHING, ...understood({ poses, favourites, folded }, refuse) };
}

function lastIn(text: string | null): Last | null {
  try {
    const found = JSON.parse(text ?? 'null') as Last | null;
    return found && { start: String(found.start), view: String(found.view) };
  } catch {
    return null; // a view is soon made again
  }
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
