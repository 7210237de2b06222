// Some points of a face, fast to pose and to differentiate: rig/handles.py of the package says the
// same in Python.
import type { Curve } from '../../../runtimes/js/index.js';
import type { Model } from '../types/model';

export type Numbers = Float64Array;

// A central difference over it loses no more to its length than to rounding: 1e-10.
const STEP = 2 ** -17;

type Path = Model['bender']['morphs'][number];
type Weighing = NonNullable<Path['fold']>;

/** A path as far as it moves the points: how each of its targets does, (3P,), with its curve. */
interface Way {
  readonly path: number; // its number
  readonly drivers: readonly number[];
  readonly delta: Numbers;
  readonly fold: Weighing | null;
  readonly bends: readonly { readonly field: Numbers; readonly curve: Weighing }[];
}

/** The points of a pose, and how they move from there. */
export interface Moving {
  readonly positions: Numbers; // (3P,)
  /** For each of `columns`, the (3P,) derivatives of the coordinates. */
  readonly rates: readonly Numbers[];
  /** (n, n) what the turning of paths adds to the normal matrix of (3P,) residuals. */
  curved(left: Numbers): Numbers;
}

export class Points {
  private readonly rest: Numbers;
  private readonly ways: readonly Way[];
  /** Sliders that move one of the points, increasing. */
  readonly columns: readonly number[];

  private readonly bender: Model['bender'];

  /**
   * @param off correctives that are left out
   * @param straight paths are chords: what the file bends is left out
   */
  constructor(
    { bender, neutral, targets }: Model,
    readonly vertices: readonly number[],
    off: readonly string[],
    straight = false,
  ) {
    this.bender = bender;
    const gather = (field: Float32Array | undefined) =>
      Float64Array.from(
        vertices.flatMap((v) => [0, 1, 2].map((axis) => field?.[3 * v + axis] ?? 0)),
      );
    this.rest = gather(neutral);
    this.ways = bender.morphs
      .map(({ name, target, fold, bends, drivers }, path) => ({
        path,
        name,
        drivers,
        fold: straight ? null : fold,
        delta: gather(target === null ? undefined : targets[target]),
        bends: (straight ? [] : bends).map((bend) => ({ curve: bend.curve, field: gather(targets[bend.target]) })),
      }))
      .filter(({ name }) => !off.includes(name))
      .filter(({ delta, bends }) => [delta, ...bends.map((b) => b.field)].some(isMoved));
    const moving = new Set(this.ways.flatMap(({ drivers }) => drivers));
    this.columns = [...moving].sort((one, other) => one - other);
  }

  /** The farthest that one path at 1 moves each of the points. */
  get reaches(): number[] {
    return this.vertices.map((_, p) =>
      this.ways.reduce((most, { delta }) => Math.max(most, lengthAt(delta, p)), 0),
    );
  }

  /** The farthest that a path of one slider at 1 moves one of the points. */
  reachOf(slider: number, point: number): number {
    const own = this.ways.filter(({ drivers }) => drivers.includes(slider));
    return own.reduce((most, { delta }) => Math.max(most, lengthAt(delta, point)), 0);
  }

  /** Where the points are and how they move with `columns`, at the values of all sliders. */
  at(values: Numbers, columns: readonly number[] = this.columns): Moving {
    const positions = this.rest.slice();
    const rates = columns.map(() => new Float64Array(positions.length));
    const times = this.bender.times(values);
    const slopes = columns.map((column) => this.slopes(values, column));
    const turning: { turn: Numbers; through: Numbers }[] = [];
    for (const way of this.ways) {
      const time = times[way.path]!;
      const speed = moved(way, time, positions);
      const through = Float64Array.from(slopes, (slope) => slope[way.path]!);
      through.forEach((rate, column) => add(rates[column]!, rate, speed));
      turning.push({ turn: turnOf(way, time, positions.length), through });
    }
    return { positions, rates, curved: (left) => curvedBy(turning, left, columns.length) };
  }

  /** The derivative of the time of each path by one slider; at a kink the mean of both sides. */
  private slopes(values: Numbers, column: number): Numbers {
    const [before, after] = [-STEP, STEP].map((step) => {
      const beside = values.slice();
      beside[column]! += step;
      return this.bender.times(beside);
    });
    return after!.map((time, path) => (time - before![path]!) / (2 * STEP));
  }
}

// Adds a path at a time to positions; returns its first derivative.
function moved({ delta, fold, bends }: Way, time: number, positions: Numbers): Numbers {
  const speed = new Float64Array(positions.length);
  add(positions, time + (fold?.(time) ?? 0), delta);
  add(speed, 1 + (fold ? rateOf(fold, time, 1) : 0), delta);
  for (const { field, curve } of bends) {
    add(positions, curve(time), field);
    add(speed, rateOf(curve, time, 1), field);
  }
  return speed;
}

function turnOf({ delta, fold, bends }: Way, time: number, length: number): Numbers {
  const turn = new Float64Array(length);
  if (fold) add(turn, rateOf(fold, time, 2), delta);
  for (const { field, curve } of bends) add(turn, rateOf(curve, time, 2), field);
  return turn;
}

// The derivative of an order of a curve, which beyond 0 and 1 goes straight on.
function rateOf({ breaks, coefficients }: Curve, time: number, order: 1 | 2): number {
  if (order > 1 && (time < 0 || time > 1)) return 0;
  const inside = Math.min(1, Math.max(0, time));
  const piece = coefficients.reduce((found, _, i) => (breaks[i]! <= inside ? i : found), 0);
  let row: readonly number[] = coefficients[piece]!;
  for (let n = 0; n < order; n += 1) row = row.map((a, power) => power * a).slice(1);
  return row.reduceRight((sum, a) => sum * (inside - breaks[piece]!) + a, 0);
}

// Only where it adds: what bends towards its goal shall make no minimum a saddle.
function curvedBy(
  turning: readonly { turn: Numbers; through: Numbers }[],
  left: Numbers,
  count: number,
): Numbers {
  const matrix = new Float64Array(count * count);
  for (const { turn, through } of turning) {
    const bend = dot(turn, left);
    if (!(bend > 0)) continue;
    through.forEach((one, i) => {
      if (one === 0) return;
      for (let j = 0; j < count; j += 1) matrix[i * count + j]! += bend * one * through[j]!;
    });
  }
  return matrix;
}

export function add(to: Numbers, factor: number, field: Numbers): void {
  if (factor === 0) return;
  for (let i = 0; i < to.length; i += 1) to[i]! += factor * field[i]!;
}

export function dot(one: Numbers, other: Numbers): number {
  let sum = 0;
  for (let i = 0; i < one.length; i += 1) sum += one[i]! * other[i]!;
  return sum;
}

function lengthAt(field: Numbers, point: number): number {
  return Math.hypot(field[3 * point]!, field[3 * point + 1]!, field[3 * point + 2]!);
}

function isMoved(field: Numbers): boolean {
  return field.some((x) => x !== 0);
}
