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
  for (const take of takes) {
    const inOwn = named.some(({ name }) => name === take.name);
    if (inOwn && filed.has(take)) continue;
    const next = { ...carried(take, sliders), name: freshName([...named, ...all], take.name) };
    if (filed.has(take)) inFile(next);
    all.push(next);
  }
  const goesOn = all.some(({ name, tracks }) => name === clip && tracks.size > 0);
  const along = { takes: all, soundOffsets: { ...soundOffsets, ...start.soundOffsets } };
  return start.clip !== null || !goesOn ? along : { ...along, clip, clipTime, range, playing };
}
