// What was done can be undone: steps of the state, one for each gesture.
import type { ViewState } from '../../types/state';
import { type Exchange, exchange, exchanged } from '../../takes/exchange';
import type { Store } from './store';

const MANY = 200; // steps that are remembered
const MOST = 2 ** 28; // bytes of curves in them, but for the last step
const PAUSE = 500; // milliseconds: changes of the same fields that follow sooner are one step
const AFTERWARDS = 150; // milliseconds after a gesture that what it has set going still belongs to it

type Field = keyof ViewState;
type Fields = Partial<ViewState>;

/** The same fields before and after. */
interface Step {
  readonly before: Fields;
  readonly after: Fields;
  /** Of one that no more joins: what makes its takes into those on its other side. */
  readonly takes?: Exchange;
}

export interface History {
  undo(): void;
  redo(): void;
  canUndo(): boolean;
  canRedo(): boolean;
  /** Forgets everything: another face is there. */
  clear(): void;
  /** Changes of the state that nobody made: they are no step. */
  aside(fields: Fields): void;
  /** Changes the state and all that is remembered alike, as if it had always been so. */
  amend(change: (fields: Fields) => Fields): void;
}

/** Remembers the changes of a store from now on. */
export function createHistory(store: Store): History {
  let past: Step[] = [];
  let future: Step[] = [];
  let silent = false;
  const gesture = followGestures();

  const record = (next: ViewState, previous: ViewState) => {
    const fields = silent ? [] : undoable(next, previous);
    if (fields.length === 0) return;
    const last = past.at(-1);
    const known = last !== undefined && fields.every((field) => field in last.before);
    const [before, after] = [part(previous, fields), part(next, fields)];
    past = gesture.goesOn(known) && last
      ? [...past.slice(0, -1), joined(last, { before, after })]
      : bounded([...past.slice(0, -1), ...(last ? [closed(last)] : []), { before, after }]);
    future = [];
  };
  store.subscribe(record);

  const silently = (fields: Fields) => {
    silent = true;
    try {
      store.update(fields);
    } finally {
      silent = false;
    }
  };
  /** Goes to one side of a step, which then knows the way back. */
  const turned = (step: Step, side: 'before' | 'after'): Step => {
    const own = closed(step);
    gesture.end();
    const now = store.get().takes;
    const takes = own.takes && exchanged(now, own.takes);
    silently({ ...own[side], ...(takes && { takes }) });
    return { ...own, ...(takes && { takes: exchange(takes, now) }) };
  };
  return {
    undo() {
      const step = past.pop();
      if (step) future.push(turned(step, 'before'));
    },
    redo() {
      const step = future.pop();
      if (step) past.push(turned(step, 'after'));
    },
    aside: silently,
    canUndo: () => past.length > 0,
    canRedo: () => future.length > 0,
    clear() {
      [past, future] = [[], []];
    },
    amend(change) {
      const amended = (step: Step) => ({
        ...step,
        before: change(step.before),
        after: change(step.after),
      });
      [past, future] = [past.map(amended), future.map(amended)];
      silently(change(store.get()));
    },
  };
}

/** The fields that differ, without those that the clock or a phone has moved. */
function undoable(next: ViewState, previous: ViewState): Field[] {
  const ticking = next.playing || previous.playing;
  const clock: Field[] = ticking ? ['playing', 'live', 't', 'clipTime'] : ['playing', 'live'];
  if (next.live || (ticking && next.clip !== null)) clock.push('weights');
  const differing = (field: Field) => !Object.is(next[field], previous[field]);
  return (Object.keys(next) as Field[]).filter((f) => differing(f) && !clock.includes(f));
}

function part(state: ViewState, fields: readonly Field[]): Fields {
  return Object.fromEntries(fields.map((field) => [field, state[field]]));
}

function joined(first: Step, second: Step): Step {
  return {
    before: { ...second.before, ...first.before },
    after: { ...first.after, ...second.after },
  };
}

/** The step without takes, of which it only knows what is another on the side before. */
function closed(step: Step): Step {
  const { takes: earlier, ...before } = step.before;
  const { takes: later, ...after } = step.after;
  return earlier && later ? { before, after, takes: exchange(later, earlier) } : step;
}

/** The last of the steps, as many as there is room for. */
function bounded(steps: readonly Step[]): Step[] {
  let room = MOST;
  const first = steps.findLastIndex((step, i) => {
    room -= step.takes?.bytes ?? 0;
    return i < steps.length - 1 && room < 0;
  });
  return steps.slice(Math.max(first + 1, steps.length - MANY));
}

/** Which changes belong together: from pointer down to up, and those that follow soon. */
function followGestures() {
  let open = false; // a step has begun that may grow
  let held = false;
  let last = -Infinity;
  let ending: ReturnType<typeof setTimeout> | undefined;
  const end = () => {
    clearTimeout(ending);
    open = false;
  };
  const release = () => {
    if (!held) return;
    held = false;
    ending = setTimeout(end, AFTERWARDS);
  };
  const listen = { capture: true, passive: true };
  addEventListener('pointerdown', () => (end(), (held = true)), listen);
  for (const over of ['pointerup', 'pointercancel']) addEventListener(over, release, listen);
  addEventListener('blur', release); // of the window: those of elements do not bubble
  // The list of a select takes the end of the gesture that opened it.
  addEventListener('pointermove', ({ buttons }) => buttons === 0 && release(), listen);
  // Keys of a control go on with what it does; those of the page each do something of their own.
  const typed = 'input:not([type=range], [type=checkbox], [type=radio]), textarea';
  const moved = 'input, select, [role=slider]';
  addEventListener(
    'keydown',
    ({ key, repeat, target }) => {
      const goesOn = repeat || (target as Element).matches?.(key.length > 1 ? moved : typed);
      if (!goesOn) end();
    },
    listen,
  );
  return {
    end,
    /** Whether a change of now belongs to the step before; `known` where that had its fields. */
    goesOn(known: boolean): boolean {
      const now = performance.now();
      const goesOn = open && (held || (known && now - last < PAUSE));
      [open, last] = [true, now];
      return goesOn;
    },
  };
}
