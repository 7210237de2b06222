// Recorded performances, between their keys.
import { numbersByName } from '../../shared/named';
import type { Clip, Model } from '../types/model';
import type { ViewState } from '../types/state';

/** The performance that a state names: one opened or edited here, or else one of a file. */
export function clipNamed(
  models: readonly Model[],
  { takes, clip }: Pick<ViewState, 'takes' | 'clip'>,
): Clip | null {
  if (clip === null) return null;
  const all = [...takes, ...models.flatMap(({ clips }) => clips)];
  return all.find(({ name, times }) => name === clip && times.length > 0) ?? null;
}

/**
 * What can be played: takes, and the performances of files that none of them replaces. Every file
 * of ours also has a clip a morph, which only plays its path.
 */
export function performances(models: readonly Model[], takes: readonly Clip[] = []): Clip[] {
  const found = new Map(takes.map((take) => [take.name, take]));
  for (const model of models) {
    const paths = new Set(model.morphs.map((morph) => morph.name));
    for (const clip of model.clips) {
      if (!paths.has(clip.name) && clip.times.length > 1 && !found.has(clip.name)) {
        found.set(clip.name, clip);
      }
    }
  }
  return [...found.values()];
}

/** First and last second of a performance. */
export function span({ times }: Clip): readonly [number, number] {
  return [times[0] ?? 0, times.at(-1) ?? 0];
}

/** What of a performance plays: from its in to its out point. */
export function played(clip: Clip, range: ViewState['range']): readonly [number, number] {
  const [first, last] = span(clip);
  if (!range) return [first, last];
  const within = (time: number) => Math.min(last, Math.max(first, time));
  return [within(range[0]), within(range[1])];
}

/** Frames a second of a clip: as recorded, or as its keys are spaced. */
export function frameRate({ recorded, times }: Clip): number {
  if (recorded) return recorded.rate;
  const first = times[0] ?? 0;
  const last = times.at(-1) ?? first;
  return last > first ? (times.length - 1) / (last - first) : 30;
}

/** Frames that a recording at its rate would have had between others. */
export function missed({ recorded, times }: Clip): number {
  if (!recorded) return 0;
  return times.reduce((sum, time, i) => {
    const steps = i > 0 ? Math.round((time - times[i - 1]!) * recorded.rate) : 1;
    return sum + Math.max(0, steps - 1);
  }, 0);
}

/** The frame of a performance at a moment: the last one that has begun. */
export function frameAt({ times }: Clip, seconds: number): number {
  // Half a millisecond: what a moment loses on its way through a field or a file.
  return Math.max(0, firstAfter(times, seconds + 5e-4) - 1);
}

/** The weight of each slider of a clip at a moment; before and after it the first and last. */
export function clipWeights(clip: Clip, seconds: number): Record<string, number> {
  const { times, tracks } = clip;
  const [before, end, share] = around(times, seconds);
  const weights = numbersByName();
  for (const [slider, track] of tracks) {
    const start = track[before] ?? 0;
    weights[slider] = start + share * ((track[end] ?? 0) - start);
  }
  return weights;
}

/** The moment of the frame before or after another moment. */
export function besideFrame(clip: Clip, seconds: number, direction: number): number {
  const { times } = clip;
  const at = frameAt(clip, seconds);
  // Between two frames, the one before is where it came from.
  const between = direction < 0 && seconds - times[at]! > 5e-4;
  return times[Math.min(times.length - 1, Math.max(0, between ? at : at + direction))]!;
}

/** The frames before and after a moment, and where between them it is, from 0 to 1. */
export function around(times: Float64Array, seconds: number): readonly [number, number, number] {
  const after = firstAfter(times, seconds);
  const before = Math.max(after - 1, 0);
  const end = Math.min(after, times.length - 1);
  const span = (times[end] ?? 0) - (times[before] ?? 0);
  return [before, end, span > 0 ? (seconds - (times[before] ?? 0)) / span : 0];
}

function firstAfter(times: Float64Array, seconds: number): number {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) <= seconds) low = middle + 1;
    else high = middle;
  }
  return low;
}
