// Recorded performances, between their keys.
import type { Clip } from '../types/model';

/** The weight of each slider of a clip at a moment; before and after it the first and last. */
export function clipWeights(clip: Clip, seconds: number): Record<string, number> {
  const { times, tracks } = clip;
  const after = firstAfter(times, seconds);
  const before = Math.max(after - 1, 0);
  const end = Math.min(after, times.length - 1);
  const span = (times[end] ?? 0) - (times[before] ?? 0);
  const share = span > 0 ? (seconds - (times[before] ?? 0)) / span : 0;
  const weights: Record<string, number> = {};
  for (const [slider, track] of tracks) {
    const start = track[before] ?? 0;
    weights[slider] = start + share * ((track[end] ?? 0) - start);
  }
  return weights;
}

function firstAfter(times: Float32Array, seconds: number): number {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((times[middle] ?? 0) <= seconds) low = middle + 1;
    else high = middle;
  }
  return low;
}
