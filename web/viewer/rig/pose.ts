// From sliders to the weights of morph targets: V₀ + Σ_j (τ_j Δ_j + Σ_k b_jk(τ_j) D_jk).
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
}

/**
 * What drives the picture: the performance where one plays, with the whole of its weights, else
 * the sliders with the master time.
 */
export function driveOf(models: readonly Model[], state: ViewState): Drive {
  const clip = clipNamed(models, state);
  if (clip) return { weights: clipWeights(clip, state.clipTime), t: 1 };
  return { weights: state.weights, t: state.t };
}

/** The morph targets that move something, at one time of the given sliders. */
export function activeTargets({ bender }: Model, { weights, t }: Drive): ActiveTarget[] {
  const values = bender.values(weights).map((weight) => t * weight);
  const active: ActiveTarget[] = [];
  bender.weights(values).forEach((weight, target) => {
    if (weight !== 0) active.push({ target, weight });
  });
  return active;
}
