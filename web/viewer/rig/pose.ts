// From sliders to the weights of morph targets: V₀ + Σ_j (τ_j Δ_j + Σ_k b_jk(τ_j) D_jk).
import { numbersByName } from '../../shared/named';
import type { Model } from '../types/model';
import type { ViewState } from '../types/state';
import { clipNamed, clipWeights } from './clips';

/** A morph target and its weight, which is not 0. */
export interface ActiveTarget {
  readonly target: number;
  readonly weight: number;
}

export type Weights = Readonly<Record<string, number>>;

/** What the sliders of a picture say, and the time that multiplies them. */
export interface Drive {
  readonly weights: Weights;
  readonly t: number;
  readonly off: readonly string[]; // correctives that do nothing
}

/**
 * What drives the picture: the performance where one plays, with the whole of its weights, else
 * the sliders with the master time.
 */
export function driveOf(models: readonly Model[], state: ViewState): Drive {
  const clip = clipNamed(models, state);
  const off = state.correctivesOff;
  if (clip) return { weights: clipWeights(clip, state.clipTime), t: 1, off };
  return { weights: state.weights, t: state.t, off };
}

/** The morph targets that move something, at one time of the given sliders. */
export function activeTargets({ bender }: Model, { weights, t, off }: Drive): ActiveTarget[] {
  const values = bender.values(weights).map((weight) => t * weight);
  const found = bender.weights(values);
  for (const { name, target, bends } of off.length > 0 ? bender.morphs : []) {
    if (!off.includes(name)) continue;
    for (const own of [target, ...bends.map((bend) => bend.target)])
      if (own !== null) found[own] = 0;
  }
  const active: ActiveTarget[] = [];
  found.forEach((weight, target) => {
    if (weight !== 0) active.push({ target, weight });
  });
  return active;
}

/** Paths that sliders of other names drive entirely. */
export function correctivesOf({ bender, sliders }: Model): Model['bender']['morphs'] {
  const own = new Set(sliders);
  return bender.morphs.filter(({ name }) => !own.has(name));
}

/** The weight of each path, by its name. */
export function pathWeights({ bender }: Model, { weights, t }: Omit<Drive, 'off'>): Weights {
  const times = bender.times(bender.values(weights).map((weight) => t * weight));
  const found = numbersByName();
  bender.morphs.forEach(({ name }, morph) => (found[name] = times[morph]!));
  return found;
}
