// Which sliders are the left and the right half of one expression.
import { sided } from './arkit';

// 'jawLeft' moves the jaw to the left: it has an opposite, not a twin.
const DIRECTIONS = /^(.*[^a-z])?(jaw|mouth|tongue|head|neck|lips?|chin|eyes|gaze)$/i;

/** The twin of every slider that has one: what the one half does, the other can do too. */
export function twins(sliders: readonly string[]): ReadonlyMap<string, string> {
  return halves(sliders, (stem) => !DIRECTIONS.test(stem));
}

/** What becomes of each slider in a mirror: its twin, or the way to the other side. */
export function opposites(sliders: readonly string[]): ReadonlyMap<string, string> {
  return halves(sliders, () => true);
}

function halves(
  sliders: readonly string[],
  fits: (stem: string) => boolean,
): ReadonlyMap<string, string> {
  const byStem = new Map<string, Map<string, string>>();
  for (const slider of sliders) {
    const { stem, side } = sided(slider);
    if (!side || !fits(stem) || stem === '') continue;
    const both = byStem.get(stem.toLowerCase()) ?? new Map<string, string>();
    byStem.set(stem.toLowerCase(), both.set(side, slider));
  }
  const found = new Map<string, string>();
  for (const both of byStem.values()) {
    const [left, right] = [both.get('left'), both.get('right')];
    if (left === undefined || right === undefined) continue;
    found.set(left, right).set(right, left);
  }
  return found;
}
