// The clock: moves t, or the seconds of a performance, while the state says that it plays.
import { clipNamed, played } from '../../rig/clips';
import { timingLaw } from '../../rig/timing';
import type { Speaker } from '../../takes/sound';
import type { Model } from '../../types/model';
import type { TimingName, ViewState } from '../../types/state';
import type { Store } from './store';

const LONGEST_STEP = 0.5; // seconds: after a pause of the page it goes on where it was

/** Where between 0 and 1 the clock stands when a timing has reached t: the first such moment. */
export function phaseOf(timing: TimingName, t: number): number {
  const law = timingLaw(timing);
  const steps = 512;
  for (let i = 1; i <= steps; i += 1) {
    const [low, high] = [law((i - 1) / steps), law(i / steps)];
    if (low <= t && t <= high) {
      return high > low ? (i - 1 + (t - low) / (high - low)) / steps : (i - 1) / steps;
    }
  }
  return 1;
}

/** A step of the clock between two ends: where it is then, which way, and whether it goes on. */
export function advanced(
  place: number,
  step: number,
  direction: 1 | -1,
  ends: readonly [number, number],
  repeat: ViewState['repeat'],
): { place: number; direction: 1 | -1; goesOn: boolean } {
  const [first, last] = ends;
  const length = last - first;
  const way = repeat === 'back and forth' ? direction : 1;
  const next = place + step * way;
  if (length <= 0) return { place: first, direction: 1, goesOn: false };
  if (way > 0 ? next < last : next > first) return { place: next, direction: way, goesOn: true };
  if (repeat === 'once') return { place: last, direction: 1, goesOn: false };
  if (repeat === 'loop') {
    return { place: first + ((next - first) % length), direction: 1, goesOn: true };
  }
  const back = way > 0 ? 2 * last - next : 2 * first - next;
  return {
    place: Math.min(last, Math.max(first, back)),
    direction: way > 0 ? -1 : 1,
    goesOn: true,
  };
}

export interface Player {
  /** Starts, or stops; starts over where a single run has ended. */
  toggle(): void;
  /** Where the clock stands between 0 and 1, for pictures of the timing. */
  phase(): number;
}

export function createPlayer(store: Store, models: () => readonly Model[], sound: Speaker): Player {
  let phase = 1;
  let reached = store.get().t; // the t this clock wrote last: any other was set by somebody else
  let direction: 1 | -1 = 1;
  let last: number | null = null;
  let waiting = 0;
  let followed = store.get().timing;

  const follow = (state: ViewState) => {
    if (state.t === reached && state.timing === followed) return;
    phase = phaseOf(state.timing, state.t);
    reached = state.t;
    followed = state.timing;
  };

  const tick = (now: number) => {
    const state = store.get();
    if (!state.playing) {
      last = null;
      return;
    }
    const elapsed = Math.min(LONGEST_STEP, (now - (last ?? now)) / 1000);
    last = now;
    const clip = clipNamed(models(), state);
    if (clip) {
      if (state.repeat !== 'back and forth') direction = 1;
      // Sound has no way back, and nothing else that keeps time where it can be heard.
      const ends = played(clip, state.range);
      const clipTime = Math.min(ends[1], Math.max(ends[0], state.clipTime));
      const heard = direction > 0 ? sound.follow({ ...state, clipTime }, ends[1]) : null;
      if (heard === null) sound.hush();
      const passed = heard === null ? elapsed * state.speed : heard - clipTime;
      const step = advanced(clipTime, passed, direction, ends, state.repeat);
      direction = step.direction;
      store.update({ clipTime: step.place, playing: step.goesOn });
    } else {
      const step = advanced(phase, elapsed / state.seconds, direction, [0, 1], state.repeat);
      direction = step.direction;
      phase = step.place;
      reached = timingLaw(state.timing)(phase);
      store.update({ t: reached, playing: step.goesOn });
      reached = store.get().t;
    }
    waiting = requestAnimationFrame(tick);
  };
  const start = () => {
    cancelAnimationFrame(waiting); // one clock, however often it is stopped and started
    waiting = requestAnimationFrame(tick);
  };

  store.subscribe((state, previous) => {
    follow(state);
    if (state.playing && !previous.playing) start();
    if (!state.playing || state.clip !== previous.clip) sound.hush();
  });
  follow(store.get());
  if (store.get().playing) start();

  return {
    phase: () => phase,
    toggle() {
      const state = store.get();
      if (state.playing) return store.update({ playing: false });
      direction = 1;
      const clip = clipNamed(models(), state);
      if (clip) {
        const [first, end] = played(clip, state.range);
        const within = state.clipTime >= first && state.clipTime < end;
        store.update({ playing: true, clipTime: within ? state.clipTime : first });
      } else {
        if (state.repeat === 'once' && phase >= 1) phase = 0;
        reached = timingLaw(state.timing)(phase);
        store.update({ playing: true, t: timingLaw(state.timing)(phase) });
      }
    },
  };
}
