// Changes of the curves of a take: each gives a new one and leaves the old as it was.
import type { Clip } from '../types/model';

/** What an edit leads to at most: a weight beyond is a slip of the hand. */
export const FARTHEST = 10;
/** Frames to each side that smoothing looks at, at most. */
export const STRONGEST = 250;

/** Frames from the first to the last, both included. */
export type Frames = readonly [number, number];

/** What happens to one curve: another of the same length. */
export type Change = (track: Float32Array) => Float32Array;

export type Smoothing = 'gaussian' | 'savitzky-golay';

/** The take with some of its curves changed. */
export function edited(clip: Clip, sliders: readonly string[], change: Change): Clip {
  const tracks = new Map(clip.tracks);
  for (const slider of sliders) {
    const track = tracks.get(slider) ?? new Float32Array(clip.times.length);
    tracks.set(slider, change(track));
  }
  return { ...clip, tracks };
}

/** 1 in a range, falling smoothly to 0 within so many frames beside it. */
export function falloff([first, last]: Frames, reach: number): (frame: number) => number {
  return (frame) => {
    const beside = Math.max(first - frame, frame - last, 0);
    if (beside === 0) return 1;
    return beside > reach ? 0 : 0.5 + 0.5 * Math.cos((Math.PI * beside) / (reach + 1));
  };
}

function blended(
  range: Frames,
  reach: number,
  at: (track: Float32Array, frame: number) => number,
): Change {
  const share = falloff(range, reach);
  return (track) =>
    track.map((own, frame) => {
      const part = share(frame);
      if (part === 0) return own;
      return Math.min(FARTHEST, Math.max(-FARTHEST, own + part * (at(track, frame) - own)));
    });
}

export function offset(by: number, range: Frames, reach: number): Change {
  return blended(range, reach, (track, frame) => track[frame]! + by);
}

export function scale(by: number, range: Frames, reach: number): Change {
  return blended(range, reach, (track, frame) => track[frame]! * by);
}

/** Moves a range later by so many frames, whole or not; what is at the ends holds. */
export function slide(by: number, range: Frames, reach: number): Change {
  return blended(range, reach, (track, frame) => {
    const from = Math.min(track.length - 1, Math.max(0, frame - by));
    const below = Math.floor(from);
    const start = track[below]!;
    return start + (from - below) * ((track[below + 1] ?? start) - start);
  });
}

/** A key at another value, and its neighbours after it. */
export function moveKey(frame: number, to: number, reach: number): Change {
  return (track) => offset(to - track[frame]!, [frame, frame], reach)(track);
}

/**
 * Weighted means over 2 n + 1 frames, n the strength. `gaussian` has the standard deviation n / 2.
 * `savitzky-golay` fits a parabola to each window (Savitzky and Golay 1964), which keeps the height
 * of peaks wider than it.
 */
export function smooth(kind: Smoothing, strength: number, range: Frames, reach: number): Change {
  const least = kind === 'gaussian' ? 1 : 2; // 3 values fit any parabola
  const half = Math.min(STRONGEST, Math.max(least, Math.round(strength)));
  const kernel = kind === 'gaussian' ? gaussian(half) : parabola(half);
  return blended(range, reach, (track, frame) => {
    let sum = 0; // in a plain loop: of long takes there are a hundred million terms
    for (let i = 0; i < kernel.length; i += 1) {
      const near = Math.min(track.length - 1, Math.max(0, frame + i - half));
      sum += kernel[i]! * track[near]!;
    }
    return sum;
  });
}

function gaussian(half: number): number[] {
  const weights = window(half).map((i) => Math.exp(-2 * (i / half) ** 2));
  const sum = weights.reduce((a, b) => a + b, 0);
  return weights.map((weight) => weight / sum);
}

/** The value in the middle of the parabola that fits 2 n + 1 values best. */
function parabola(n: number): number[] {
  const scaled = (i: number) =>
    (3 * (3 * n * n + 3 * n - 1 - 5 * i * i)) / ((2 * n + 3) * (2 * n + 1) * (2 * n - 1));
  return window(n).map(scaled);
}

function window(half: number): number[] {
  return Array.from({ length: 2 * half + 1 }, (_, i) => i - half);
}
