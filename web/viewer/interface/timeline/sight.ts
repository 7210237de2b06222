// What of a take the timeline shows, and where on it a moment and a value lie.
import type { Clip } from '../../types/model';

/** Seconds at the left and the right end. */
export type Sight = readonly [number, number];

const FEWEST = 4; // frames that the nearest sight still shows

/** The sight brought nearer (factor > 1) or farther about a moment, within a take. */
export function zoomed(
  [from, to]: Sight,
  factor: number,
  about: number,
  whole: Sight,
  frame: number,
): Sight {
  const length = Math.min(whole[1] - whole[0], Math.max(FEWEST * frame, (to - from) / factor));
  const share = to > from ? (about - from) / (to - from) : 0.5;
  return placed(about - share * length, length, whole);
}

/** The sight of a length that begins at a moment, moved so that it lies within a take. */
export function placed(from: number, length: number, [first, last]: Sight): Sight {
  const start = Math.max(first, Math.min(from, last - length));
  return [start, Math.min(last, start + length)];
}

const extents = new WeakMap<Float32Array, readonly [number, number]>();

/** Least and largest value of a curve. */
export function extent(track: Float32Array): readonly [number, number] {
  let found = extents.get(track);
  if (!found) {
    let [low, high] = [0, 0];
    for (const value of track) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
    extents.set(track, (found = [low, high]));
  }
  return found;
}

/** Names of the curves that are not 0 throughout. */
export function moving({ tracks }: Clip): string[] {
  return [...tracks].flatMap(([name, track]) =>
    extent(track).every((end) => end === 0) ? [] : [name],
  );
}

/** The values that the curves reach: 0 to 1, or beyond. */
export function reached({ tracks }: Clip): readonly [number, number] {
  let [low, high] = [0, 1];
  for (const track of tracks.values()) {
    const [least, most] = extent(track);
    [low, high] = [Math.min(low, least), Math.max(high, most)];
  }
  return [low, high];
}

/** Where things are on the timeline, in CSS pixels. */
export interface Plot {
  readonly width: number;
  readonly top: number; // of the curves, below the ruler and the sound
  readonly height: number; // of the whole
  readonly sight: Sight;
  readonly values: readonly [number, number];
}

const EDGE = 4; // pixels above the highest and below the lowest value

export function xOf({ width, sight: [from, to] }: Plot, seconds: number): number {
  return to > from ? ((seconds - from) / (to - from)) * width : 0;
}

export function secondsAt({ width, sight: [from, to] }: Plot, x: number): number {
  return from + (x / width) * (to - from);
}

export function yOf({ top, height, values: [low, high] }: Plot, value: number): number {
  return height - EDGE - ((value - low) / (high - low)) * (height - top - 2 * EDGE);
}

export function valueAt({ top, height, values: [low, high] }: Plot, y: number): number {
  return low + ((height - EDGE - y) / (height - top - 2 * EDGE)) * (high - low);
}

/** The frame nearest to a moment. */
export function nearestFrame({ times }: Clip, seconds: number): number {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle]! <= seconds) low = middle;
    else high = middle;
  }
  return seconds - times[low]! < times[high]! - seconds ? low : high;
}
