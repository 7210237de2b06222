// One pull at a vertex of the face, from where it was taken to where it is let go.
import { numberOf } from '../../shared/named';
import type { Weights } from '../rig/pose';
import type { Model } from '../types/model';
import type { Position } from '../types/stage';
import type { ViewState } from '../types/state';
import { acrossFrom, evened } from './mirror';
import { Points } from './points';
import { Search } from './solving';

// Cost of a slider: about this part of the farthest that one slider moves the point is given away
// for plainer weights, which is less than a hand can see.
const PRIOR = 5e-4;
// Out of reach, sliders that bring the point hardly nearer are better left alone.
const PRIOR_BEYOND = 1e-2;
// A slider that moves a point by less than this share of what moves it farthest is about others.
const LEAST = 0.1;
// A hand says where a point is to be on the picture, and hardly how far behind it.
const DEPTH = 0.05;
const LEAST_REACH = 1e-3; // of D: what moves less is still
const DIGITS = 1e4;
const MOVED = 0.005;
const BEYOND = 10; // times what counts as reached: what an eye sees

export interface Reached {
  readonly weights: Weights;
  readonly position: Position; // of the vertex
  readonly goal: Position;
  /** How far it is from its goal across the picture; 0 where it has reached it. */
  readonly left: number;
}

export class Gesture {
  readonly start: Weights;
  /** Where the vertex was taken. */
  readonly from: Position;
  private readonly search: Search;
  private readonly rest: Float64Array;
  private readonly across: number | null;
  private readonly pulled: number; // handles that the hand moves
  private readonly mirror: boolean;
  private last: Weights;

  private constructor(
    readonly model: Model,
    readonly vertex: number,
    { weights, t, mirror, pins, correctivesOff: off }: ViewState,
    private readonly eye: Position,
  ) {
    this.start = this.last = weights;
    this.across = mirror ? acrossFrom(model, vertex) : vertex;
    const pulled = this.across === null ? [vertex] : [...new Set([vertex, this.across])];
    this.pulled = pulled.length;
    const movable = new Points(model, pins, off).reaches.map(
      (reach) => reach > LEAST_REACH * model.diameter,
    );
    const held = pins.filter((pin, i) => movable[i] && !pulled.includes(pin));
    this.search = new Search(
      model,
      [...pulled, ...held],
      { t, off },
      (reach, most, point) => point < pulled.length && reach > 0 && reach >= LEAST * most,
    );
    this.rest = this.search.positions(weights);
    this.from = positionAt(this.rest, 0);
    this.mirror = mirror;
  }

  /**
   * Null where no slider moves the vertex.
   *
   * @param eye from where the face is seen
   */
  static at(model: Model, vertex: number, state: ViewState, eye: Position): Gesture | null {
    const gesture = new Gesture(model, vertex, state, eye);
    const reach = gesture.search.points.reaches[0] ?? 0;
    return reach > LEAST_REACH * model.diameter ? gesture : null;
  }

  /** Brings the vertex to a place, or as near as the sliders can. */
  pull(to: Position): Reached {
    const { model, start, search } = this;
    const goals = this.goals(to);
    const ray = direction(this.eye, to);
    const along = [ray, mirrored(ray)].slice(0, this.pulled);
    const ask = { start, along, share: DEPTH };
    let solved = search.solve({ ...ask, goals, prior: PRIOR, near: this.last });
    const beyond = BEYOND * solved.within;
    if (this.left(solved.weights, goals, ray) > beyond) {
      const { weights: near } = solved;
      solved = search.solve({ ...ask, goals: search.positions(near), prior: PRIOR_BEYOND, near });
    }
    this.last = solved.weights;
    const weights = rounded(
      this.mirror ? evened(model, solved.weights, start) : solved.weights,
    );
    const position = positionAt(search.positions(weights), 0);
    const left = this.left(weights, goals, ray);
    return { weights, position, goal: positionAt(goals, 0), left: left > beyond ? left : 0 };
  }

  /** The sliders that are elsewhere than when the vertex was taken. */
  moved(weights: Weights): string[] {
    const away = (name: string) => Math.abs(numberOf(weights, name) - numberOf(this.start, name));
    return this.model.sliders.filter((name) => away(name) > MOVED);
  }

  /** How far the vertex is from its goal, as the picture shows it. */
  private left(weights: Weights, goals: Float64Array, ray: Position): number {
    const position = this.search.positions(weights);
    const apart = ray.map((_, axis) => goals[axis]! - position[axis]!);
    const behind = apart.reduce((sum, own, axis) => sum + own * ray[axis]!, 0);
    return Math.hypot(...apart.map((own, axis) => own - behind * ray[axis]!));
  }

  // What nobody pulls stays where it was; the other side goes the mirrored way.
  private goals(to: Position): Float64Array {
    const goals = this.rest.slice();
    const by = to.map((own, axis) => own - this.from[axis]!);
    if (this.mirror && this.across === this.vertex) by[0] = 0;
    const ways = [by, mirrored(by)].slice(0, this.pulled);
    ways.flat().forEach((own, i) => (goals[i]! += own));
    return goals;
  }
}

function direction(from: Position, to: Position): Position {
  const [x, y, z] = to.map((own, axis) => own - from[axis]!) as [number, number, number];
  const length = Math.hypot(x, y, z) || 1;
  return [x / length, y / length, z / length];
}

function mirrored([x, y, z]: readonly number[]): [number, number, number] {
  return [-x!, y!, z!];
}

function positionAt(all: Float64Array, point: number): Position {
  return [all[3 * point]!, all[3 * point + 1]!, all[3 * point + 2]!];
}

function rounded(weights: Weights): Weights {
  const entries = Object.entries(weights).map(
    ([name, weight]) => [name, Math.round(DIGITS * weight) / DIGITS] as const,
  );
  return Object.fromEntries(entries.filter(([, weight]) => weight !== 0));
}
