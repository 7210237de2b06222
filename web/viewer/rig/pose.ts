// From sliders to the weights of morph targets: V₀ + Σ_j (τ_j Δ_j + Σ_k b_jk(τ_j) D_jk).
import type { Model, Morph } from '../types/model';
import type { ViewState } from '../types/state';
import { clipWeights } from './clips';
import { bendWeight } from './curve';

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
  if (state.clip !== null) {
    for (const model of models) {
      const clip = model.clips.find(({ name }) => name === state.clip);
      if (clip) return { weights: clipWeights(clip, state.clipTime), t: 1 };
    }
  }
  return { weights: state.weights, t: state.t };
}

/** The weight of each slider in the picture, before the master time. */
export function shownWeights(models: readonly Model[], state: ViewState): Weights {
  return driveOf(models, state).weights;
}

/** The morph targets that move something, at one time of the given sliders. */
export function activeTargets(model: Model, { weights, t }: Drive): ActiveTarget[] {
  const sums = new Map<number, number>();
  const add = (target: number, weight: number) => {
    if (weight !== 0) sums.set(target, (sums.get(target) ?? 0) + weight);
  };
  const drivers = driversOf(model);
  for (const morph of model.morphs) {
    const tau = drivenBy(morph, drivers, weights, t);
    if (tau === 0) continue;
    add(morph.delta, tau);
    for (const { target, curve } of morph.bends) add(target, bendWeight(curve, tau));
  }
  return [...sums].map(([target, weight]) => ({ target, weight }));
}

/** τ of a morph: t times its weight, or the product over the drivers of a corrective. */
function drivenBy(
  morph: Morph,
  drivers: ReadonlyMap<string, readonly string[]>,
  weights: Weights,
  t: number,
): number {
  const names = drivers.get(morph.name);
  if (!names) return t * weightOf(weights, morph.name);
  return names.reduce((product, name) => product * t * weightOf(weights, name), 1);
}

function weightOf(weights: Weights, name: string): number {
  const weight = Object.hasOwn(weights, name) ? (weights[name] ?? 0) : 0;
  return Number.isFinite(weight) ? weight : 0;
}

const known = new WeakMap<Model, ReadonlyMap<string, readonly string[]>>();

function driversOf(model: Model): ReadonlyMap<string, readonly string[]> {
  let drivers = known.get(model);
  if (!drivers) {
    drivers = new Map(model.correctives.map((c) => [c.name, c.drivers]));
    known.set(model, drivers);
  }
  return drivers;
}

/** What has a slider: every morph but the correctives that others drive entirely. */
export function slidersOf(model: Pick<Model, 'morphs' | 'correctives'>): string[] {
  const drivers = new Map(model.correctives.map((c) => [c.name, c.drivers]));
  return model.morphs
    .map(({ name }) => name)
    .filter((name) => drivers.get(name)?.includes(name) ?? true);
}
