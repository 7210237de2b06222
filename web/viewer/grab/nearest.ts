// Least squares with bounds and few moves, as rig/nearest.py of the package says it in Python:
//
//     ½ |r(x)|² + λ Σ |x_j − x⁰_j| + ½ ρ |x − x⁰|²,    low ≤ x ≤ high
//
// Levenberg–Marquardt steps, each the exact minimum of its quadratic model in the box, which an
// active set finds; a step that leaves a curved way along which the residuals stay small is brought
// back by a second-order correction.
import { choleskySolve, times } from './matrices';
import { add, dot, type Moving, type Numbers } from './points';

/** Where parameters may be, where they start, and what it costs to leave there. */
export interface Box {
  readonly low: Numbers;
  readonly high: Numbers;
  readonly start: Numbers;
  readonly prior: number; // λ
  readonly ridge: number; // ρ
  readonly fine: number; // of residuals: those that stay large shall not blind the search to others
}

/** Residuals at parameters, (R,), the (R,) derivatives by each, and what their turning adds. */
export interface Residuals extends Pick<Moving, 'rates' | 'curved'> {
  readonly left: Numbers;
}

const STEPS = 60;
// The search ends with a step of less than this in every parameter, or that promises no more than
// this part of the cost.
const PRECISION = 1e-8;
const WORTH = 3e-4;
// Damping where the model has held so far, as a part of the largest diagonal element; it is raised
// tenfold, and by ten times more for each time in a row.
const LEAST_DAMPING = 1e-8;
const RAISE = 10;
// Parameters that have more than this part of the most to gain are let go together.
const TOGETHER = 0.3;

/** The minimum that is downhill from a point in the box. */
export function nearest(residuals: (x: Numbers) => Residuals, box: Box, near: Numbers): Numbers {
  const tried = (x: Numbers) => {
    const found = residuals(x);
    return { x, ...found, cost: 0.5 * dot(found.left, found.left) + costOf(box, x) };
  };
  let here = tried(near);
  let aim = near;
  let damping = LEAST_DAMPING;
  let raised = RAISE;
  for (let step = 0; step < STEPS; step += 1) {
    const { x, left, rates, cost } = here;
    const n = x.length;
    const curved = here.curved(left);
    const model = curved.slice();
    for (let i = 0; i < n; i += 1)
      for (let j = 0; j <= i; j += 1) {
        const both = dot(rates[i]!, rates[j]!);
        model[i * n + j]! += both;
        if (i !== j) model[j * n + i]! += both;
      }
    let largest = 0;
    for (let i = 0; i < n; i += 1) largest = Math.max(largest, model[i * n + i]!);
    for (let i = 0; i < n; i += 1) model[i * n + i]! += damping * largest;
    const towards = (residual: Numbers) => {
      const offset = times(model, x);
      return offset.map((own, i) => dot(rates[i]!, residual) - own);
    };
    // From the aim before: what is at a bound there mostly stays.
    aim = modelMinimum(model, towards(left), box, aim);
    const moved = aim.map((to, i) => to - x[i]!);
    const modelled = left.slice();
    moved.forEach((by, i) => add(modelled, by, rates[i]!));
    const promised =
      cost -
      0.5 * dot(modelled, modelled) -
      costOf(box, aim) -
      0.5 * dot(moved, times(curved, moved));
    const worth = Math.min(WORTH * cost, 0.5 * box.fine ** 2);
    if (moved.every((by) => Math.abs(by) <= PRECISION) || promised <= worth) break;
    let trial = tried(aim);
    if (cost - trial.cost <= 0.5 * promised) {
      const turned = left.map((own, i) => own + trial.left[i]! - modelled[i]!);
      aim = modelMinimum(model, towards(turned), box, aim);
      const again = tried(aim);
      if (again.cost < trial.cost) trial = again;
    }
    if (trial.cost < cost) {
      // The more of what the model promised has come, the longer the next step.
      if (cost - trial.cost > 0.5 * promised) damping = Math.max(0.1 * damping, LEAST_DAMPING);
      [here, raised] = [trial, RAISE];
    } else {
      damping *= raised;
      raised *= RAISE;
    }
  }
  return here.x;
}

/** λ Σ |x_j − x⁰_j| + ½ ρ |x − x⁰|². */
function costOf({ start, prior, ridge }: Box, x: Numbers): number {
  let sum = 0;
  for (let i = 0; i < x.length; i += 1) {
    const away = x[i]! - start[i]!;
    sum += prior * Math.abs(away) + 0.5 * ridge * away * away;
  }
  return sum;
}

/**
 * The minimum over the box of ½ xᵀMx + oᵀx and the other terms, from near it; M is definite. Those
 * with much to gain are let go, and all that are free go to their common minimum, or to where the
 * first of them meets a bound or its start, and stays.
 */
function modelMinimum(damped: Numbers, along: Numbers, box: Box, near: Numbers): Numbers {
  const { low, high, start, prior, ridge } = box;
  const n = near.length;
  const matrix = damped.slice();
  let largest = 0;
  for (let i = 0; i < n; i += 1) {
    largest = Math.max(largest, damped[i * n + i]!);
    matrix[i * n + i]! += ridge;
  }
  const offset = along.map((own, i) => own - ridge * start[i]!);
  const x = near.slice();
  const sides = x.map((own, i) => Math.sign(own - start[i]!));
  const free = Array.from(x, (own, i) => own > low[i]! && own < high[i]! && sides[i] !== 0);
  const enough = 1e-6 * prior + 1e-15 * largest;
  const slopeAt = () => {
    const slope = times(matrix, x);
    add(slope, 1, offset);
    return slope;
  };
  for (let round = 0; round < 20 * n + 20; round += 1) {
    let own = [...x.keys()].filter((i) => free[i]);
    while (own.length > 0) own = goTogether(own);
    const slope = slopeAt();
    // By how much the cost falls when each goes up, or down.
    const gains = Array.from(slope, (steep, i) => {
      if (free[i]) return 0;
      const up = x[i]! < high[i]! ? -steep - (x[i]! >= start[i]! ? prior : -prior) : 0;
      const down = x[i]! > low[i]! ? steep - (x[i]! <= start[i]! ? prior : -prior) : 0;
      return up >= down ? Math.max(up, 0) : -Math.max(down, 0);
    });
    const most = gains.reduce((most, gain) => Math.max(most, Math.abs(gain)), 0);
    if (most <= enough) break;
    gains.forEach((gain, i) => {
      if (Math.abs(gain) < TOGETHER * most) return;
      free[i] = true;
      sides[i] = x[i] === start[i] ? Math.sign(gain) : Math.sign(x[i]! - start[i]!);
    });
  }
  return x;

  // Moves those that are free; returns those that still are.
  function goTogether(own: readonly number[]): number[] {
    const slope = slopeAt();
    const pull = Float64Array.from(own, (i) => slope[i]! + prior * sides[i]!);
    const step = choleskySolve(matrix, n, own, pull);
    // On one side of its start the cost of a parameter is smooth.
    const kept = (i: number, to: number) =>
      sides[i]! > 0
        ? Math.min(Math.max(to, start[i]!), high[i]!)
        : Math.min(Math.max(to, low[i]!), start[i]!);
    const within = own.map((i, k) => kept(i, x[i]! - step[k]!));
    const parts = own.map((i, k) => {
      const aim = x[i]! - step[k]!;
      return within[k] === aim ? Infinity : (within[k]! - x[i]!) / (aim - x[i]!);
    });
    const part = Math.min(...parts);
    return own.filter((i, k) => {
      const met = parts[k]! <= part;
      x[i] = met ? within[k]! : kept(i, x[i]! - part * step[k]!);
      if (met && part < Infinity) free[i] = false;
      return !met;
    });
  }
}
