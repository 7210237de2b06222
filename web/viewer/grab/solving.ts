// Slider weights that bring points of a face to positions, after Lewis and Anjyo, Direct
// Manipulation Blendshapes (2010), on bent paths: what `Rig.solve` of the package finds.
import { numberOf, numbersByName } from '../../shared/named';
import type { Drive, Weights } from '../rig/pose';
import type { Model } from '../types/model';
import { nearest } from './nearest';
import { dot, type Numbers, Points } from './points';

export interface Solved {
  readonly weights: Weights; // those that are not 0
  /** How far each handle is left from its goal, in the order of the handles. */
  readonly distances: readonly number[];
  /** A handle no farther than this has reached its goal. */
  readonly within: number;
}

// As in rig/solving.py: a first search at a strong prior settles which sliders move.
const FIRST_PRIOR = 1e-4;
const RIDGE = 1e-3;
const LEAST_RIDGE = 1e-12;
const REACHED = 1e-3;

// Of a path that sets out or arrives slower than at this part of its mean speed.
const STALLED = 0.25;

export interface Ask {
  readonly goals: ArrayLike<number>; // (3P,) where the vertices are to be
  readonly start: Weights; // what the sliders cost is counted from
  /** Cost of moving a slider by 1, beside half the squared distances over the farthest it moves one. */
  readonly prior: number;
  readonly near?: Weights; // where the search begins, if not at the start
  /** For each of the first points a direction, of length 1, along which it may be left away. */
  readonly along?: readonly (readonly number[])[];
  readonly share?: number; // of what is left there that counts
}

/** The search for the weights under which some vertices are somewhere. */
export class Search {
  readonly points: Points;
  private readonly chords: Points;
  private readonly scale: number;
  private readonly t: number;
  private readonly columns: readonly number[];

  /**
   * @param drive the picture's: the value of a slider is t times its weight
   * @param only sliders that may move, by what they do: how far one moves a vertex at most, and how
   *   far the strongest does
   */
  constructor(
    private readonly model: Model,
    vertices: readonly number[],
    { t, off }: Omit<Drive, 'weights'>,
    only: (reach: number, most: number, point: number) => boolean = () => true,
  ) {
    this.t = t;
    const points = (this.points = new Points(model, vertices, off));
    this.chords = new Points(model, vertices, off, true);
    const { reaches } = points;
    this.scale = Math.max(0, ...reaches) || 1;
    this.columns = points.columns.filter((column) =>
      reaches.some((most, point) => only(points.reachOf(column, point), most, point)),
    );
  }

  /** Where the vertices are. */
  positions(weights: Weights): Numbers {
    return this.points.at(this.values(weights), []).positions;
  }

  solve(ask: Ask): Solved {
    const { columns, model } = this;
    const { start, near = start } = ask;
    const at = (weights: Weights) =>
      Float64Array.from(columns, (column) => numberOf(weights, model.sliders[column]!));
    const first = at(start);
    const low = first.map((weight) => Math.min(0, weight));
    const high = first.map((weight) => Math.max(1, weight));
    const from = at(near).map((weight, i) => Math.min(Math.max(weight, low[i]!), high[i]!));
    const search = (points: Points, x: Numbers) => {
      const box = { low, high, start: first, fine: REACHED };
      for (const prior of new Set([Math.max(ask.prior, FIRST_PRIOR), ask.prior])) {
        const ridge = Math.max(RIDGE * prior, LEAST_RIDGE);
        const residuals = (x: Numbers) => this.residuals(points, ask, x);
        x = nearest(residuals, { ...box, prior, ridge }, x);
      }
      return this.told(ask, x);
    };
    const found = search(this.points, from);
    if (found.distances.every((distance) => distance <= found.within)) return found;
    if (!this.stalls(start, from)) return found;
    // Paths like those of beams begin without speed, and nothing leads away from there: the chords
    // say which sliders are needed.
    const straight = search(this.chords, from);
    const other = search(this.points, at(straight.weights));
    return other.left < found.left ? other : found;
  }

  private residuals(points: Points, ask: Ask, x: Numbers) {
    const { t, scale } = this;
    const moving = points.at(this.values(ask.start, x), this.columns);
    return {
      left: counted(ask, moving.positions.map((own, i) => (own - ask.goals[i]!) / scale)),
      rates: moving.rates.map((rate) => counted(ask, rate.map((own) => (t * own) / scale))),
      curved: (left: Numbers) =>
        moving.curved(counted(ask, left.slice())).map((own) => (t * t * own) / scale),
    };
  }

  /** Whether a slider moves the vertices far, yet hardly from where it is. */
  private stalls(start: Weights, x: Numbers): boolean {
    const values = this.values(start, x);
    const chords = this.chords.at(values, this.columns).rates;
    return this.points
      .at(values, this.columns)
      .rates.some((rate, i) => Math.sqrt(dot(rate, rate)) < STALLED * Math.hypot(...chords[i]!));
  }

  private told(ask: Ask, x: Numbers): Solved & { left: number } {
    const { goals, start } = ask;
    const { columns, model, points, scale } = this;
    const { positions } = points.at(this.values(start, x), []);
    const weights = numbersByName(start);
    columns.forEach((column, i) => (weights[model.sliders[column]!] = x[i]!));
    const apart = counted(ask, positions.map((own, i) => own - goals[i]!));
    const distances = points.vertices.map((_, p) => Math.hypot(...apart.subarray(3 * p, 3 * p + 3)));
    return {
      weights: Object.fromEntries(Object.entries(weights).filter(([, weight]) => weight !== 0)),
      distances,
      within: REACHED * scale,
      left: Math.hypot(...distances),
    };
  }

  /** The values of all sliders, those that are searched for at x. */
  private values(weights: Weights, x?: Numbers): Numbers {
    const values = Float64Array.from(this.model.bender.values(weights), (weight) => this.t * weight);
    if (x) this.columns.forEach((column, i) => (values[column] = this.t * x[i]!));
    return values;
  }
}

/** Differences of points as they count, in place. */
function counted({ along = [], share = 1 }: Ask, apart: Numbers): Numbers {
  along.forEach((way, p) => {
    const far = way.reduce((sum, own, axis) => sum + own * apart[3 * p + axis]!, 0);
    way.forEach((own, axis) => (apart[3 * p + axis]! -= (1 - share) * far * own));
  });
  return apart;
}
