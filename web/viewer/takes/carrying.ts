// What people have no file of goes neither when another face comes nor, where the browser does not
// keep it, unasked with the page.
import { freshName } from '../interface/poses/list';
import type { Clip, Scene } from '../types/model';
import type { ViewState } from '../types/state';
import { carried } from './reading';

const filed = new WeakSet<Clip>();

/** From now on this take, as it is, is nothing that could be lost. */
export function inFile(take: Clip): void {
  filed.add(take);
}

export function isInFile(take: Clip): boolean {
  return filed.has(take);
}

/** Asks whoever leaves the page while a take is edited, and neither saved nor kept. */
export function askBeforeLeaving(state: () => ViewState, holds: (take: Clip) => boolean): void {
  addEventListener('beforeunload', (event) => {
    if (state().takes.some((take) => !filed.has(take) && !holds(take))) event.preventDefault();
  });
}

/** What of a state goes on with another scene, beside its own start: takes, and the one that plays. */
export function goingOn(
  { takes, clip, clipTime, range, playing, soundOffsets }: ViewState,
  { models }: Scene,
  start: Partial<ViewState>,
): Partial<ViewState> {
  const sliders = models[start.shown?.[0] ?? 0]?.sliders ?? [];
  const clips = models.flatMap((model) => model.clips);
  clips.forEach(inFile);
  const named = [...(start.takes ?? []), ...clips];
  const all = [...(start.takes ?? [])];
  let plays = clip;
  for (const take of takes) {
    const fitted = carried(take, sliders);
    const own = named.find(({ name }) => name === take.name);
    const again = filed.has(take) && own?.times.length === take.times.length;
    const size = fitted.tracks.size;
    const same = named.find((one) => size && size === one.tracks.size && isSame(fitted, one));
    const next = (again ? own : same) ?? {
      ...fitted,
      name: freshName([...named, ...all], take.name),
    };
    if (take.name === clip) plays = next.name;
    if (named.includes(next)) continue;
    if (filed.has(take)) inFile(next);
    all.push(next);
  }
  const goesOn = all.some(({ name, tracks }) => name === plays && tracks.size > 0);
  const along = { takes: all, soundOffsets: { ...soundOffsets, ...start.soundOffsets } };
  return start.clip !== null || !goesOn ? along : { ...along, clip: plays, clipTime, range, playing };
}

/** Whether all curves of one are also of the other, at the same times. */
export function isSame(one: Clip, other: Clip): boolean {
  const equal = (a: ArrayLike<number>, b?: ArrayLike<number>) =>
    a.length === b?.length && Array.prototype.every.call(a, (value, i) => value === b[i]);
  return equal(one.times, other.times) && [...one.tracks].every(([slider, track]) =>
    equal(track, other.tracks.get(slider)),
  );
}
