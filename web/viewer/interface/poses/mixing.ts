// From the weights of a face to others: blended with a pose, mirrored, drawn by lot.
import { numberOf, numbersByName } from '../../../shared/named';
import type { NamedPose } from '../../types/state';

type Weights = NamedPose['weights'];
export type Limits = readonly [least: number, most: number];

const ACTIVE = 6; // sliders, of those drawn by lot, that move: with all of them there is no face left

/** The way from the present weights to a pose, or with `onTop` the pose added to them. */
export function mixed(
  present: Weights,
  pose: Weights,
  strength: number,
  onTop: boolean,
  [least, most]: Limits,
): Weights {
  const names = new Set([...Object.keys(present), ...Object.keys(pose)]);
  const weight = (name: string) => {
    const [from, to] = [numberOf(present, name), numberOf(pose, name)];
    if (strength === 1 && !onTop) return to;
    // What was beyond the limits before is no business of this.
    const limit = (value: number) =>
      Math.min(Math.max(most, from, to), Math.max(Math.min(least, from, to), value));
    return limit(from + strength * (onTop ? to : to - from));
  };
  return Object.fromEntries([...names].map((name) => [name, weight(name)]));
}

/** Left and right exchanged. */
export function mirrored(weights: Weights, opposites: ReadonlyMap<string, string>): Weights {
  return Object.fromEntries(
    Object.entries(weights).map(([name, weight]) => [opposites.get(name) ?? name, weight]),
  );
}

/**
 * Weights with some of the given sliders drawn by lot, within limits, and the others of them at 0.
 *
 * @param twins pairs that move together; empty where each moves for itself.
 */
export function drawn(
  weights: Weights,
  sliders: readonly string[],
  twins: ReadonlyMap<string, string>,
  [least, most]: Limits,
  lot: () => number,
): Weights {
  const left = new Set(sliders);
  const found = numbersByName(weights);
  const units: string[][] = [];
  for (const slider of sliders) {
    if (!left.delete(slider)) continue;
    const twin = twins.get(slider);
    if (twin !== undefined) left.delete(twin);
    units.push(twin === undefined ? [slider] : [slider, twin]);
  }
  const chosen = shuffled(units, lot).slice(0, ACTIVE);
  for (const name of units.flat()) found[name] = 0;
  for (const unit of chosen) {
    const weight = Number((least + lot() * (most - least)).toFixed(2));
    for (const name of unit) found[name] = weight;
  }
  return found;
}

/** Numbers from 0 to 1, the same for the same seed. */
export function lots(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    // A Weyl sequence through the finaliser of MurmurHash3.
    state = (state + 0x9e3779b9) >>> 0;
    let mixed = state;
    mixed = Math.imul(mixed ^ (mixed >>> 16), 0x85ebca6b);
    mixed = Math.imul(mixed ^ (mixed >>> 13), 0xc2b2ae35);
    return ((mixed ^ (mixed >>> 16)) >>> 0) / 2 ** 32;
  };
}

function shuffled<T>(items: readonly T[], lot: () => number): T[] {
  return items
    .map((item) => ({ item, place: lot() }))
    .sort((a, b) => a.place - b.place)
    .map(({ item }) => item);
}
