// Time laws: when a performance is where on a path, kept apart from the path.
import type { TimingName } from '../types/state';

/** From the share of the clip that has passed to the t of the path. */
export type TimingLaw = (share: number) => number;

const CLOSING = 0.3; // share of a blink until the lid is closed

const minimumJerk: TimingLaw = (t) => t ** 3 * (10 + t * (6 * t - 15));

const LAWS: Readonly<Record<TimingName, TimingLaw>> = {
  linear: (t) => t,
  smoothstep: (t) => t * t * (3 - 2 * t),
  'minimum-jerk': minimumJerk,
  cosine: (t) => Math.sin(0.5 * Math.PI * t) ** 2,
  blink: (t) => minimumJerk(t < CLOSING ? t / CLOSING : Math.min((1 - t) / (1 - CLOSING), 1)),
};

/** The time law of a name; before its clip it holds its first value, after it the last. */
export function timingLaw(name: TimingName): TimingLaw {
  const law = LAWS[name];
  return (share) => law(Math.min(Math.max(share, 0), 1));
}
