// Which sliders are the left and the right half of one expression.
import { sided } from './arkit';

// 'jawLeft' moves the jaw to the left: it has an opposite, not a twin.
const DIRECTIONS = /^(.*[^a-z])?(jaw|mouth|tongue|head|neck|lips?|chin|eyes|gaze)$/i;

/** The twin of every slider that has one. */
export function twins(sliders: readonly string[]): ReadonlyMap<string, string> {
  const byStem = new Map<string, Map<string, string>>();
  for (const slider of sliders) {
    const { stem, side } = sided(slider);
    if (!side || DIRECTIONS.test(stem) || stem === '') continue;
    const halves = byStem.get(stem.toLowerCase()) ?? new Map<string, string>();
    byStem.set(stem.toLowerCase(), halves.set(side, slider));
  }
  const found = new Map<string, string>();
  for (const halves of byStem.values()) {
    const [left, right] = [halves.get('left'), halves.get('right')];
    if (left === undefined || right === undefined) continue;
    found.set(left, right).set(right, left);
  }
  return found;
}
