// What is being placed, where: the marks, the place in view and the point that is next.
import { exchanged, putRight } from './geometry/sides';
import { marksOf } from './state/document';
import { MarkHistory } from './state/marks';
import type { Mark, Place, Point, Task } from './types/task';

export class Desk {
  readonly history: MarkHistory;
  current = 0;
  /** The point that a click places; null once no more are asked for here. */
  active: string | null = null;
  /** Where a vertex of the template in view is. */
  pointOf: ((vertex: number) => Point | null) | null = null;
  private readonly heard = new Set<(placed: boolean) => void>();

  constructor(readonly task: Task) {
    this.history = new MarkHistory(marksOf(task));
    // The first place where something is left to do.
    const lacking = task.places.findIndex((place) => this.missing(null, place) !== null);
    this.current = Math.max(0, lacking);
    this.active = this.missing(null);
  }

  /** Calls back after every change; `placed` where marks are others now. */
  listen(changed: (placed: boolean) => void): void {
    this.heard.add(changed);
  }

  get place(): Place {
    return this.task.places[this.current]!;
  }

  get own(): Readonly<Record<string, Mark>> {
    return this.history.of(this.place.key);
  }

  /** In how many photographs of the pose a point is, or on this surface. */
  count(name: string, { kind, pose, key }: Place = this.place): number {
    const { places } = this.task;
    const same = places.filter((one) => (kind === 'photograph' ? one.kind === kind && one.pose === pose : one.key === key));
    return same.filter((one) => this.history.of(one.key)[name]).length;
  }

  /** In how many photographs a point is asked for here. */
  get asked(): number {
    return this.askedOf(this.place);
  }

  go(number: number): void {
    const { length } = this.task.places;
    this.current = ((number % length) + length) % length;
    this.active = this.missing(null);
    this.tell(false);
  }

  choose(name: string | null): void {
    this.active = name;
    this.tell(false);
  }

  step(by: number): void {
    const { names } = this.task;
    const from = this.active === null ? (by > 0 ? -1 : 0) : names.indexOf(this.active);
    this.choose(names[(from + by + names.length) % names.length] ?? null);
  }

  nextMissing(): void {
    this.choose(this.missing(this.active));
  }

  /** Places the active point; the next one that is missing is then active. */
  put(mark: Mark): void {
    if (this.active === null) return;
    const name = this.active;
    const moved = Boolean(this.own[name]);
    this.history.set(this.place.key, name, mark);
    if (!moved) this.active = this.missing(name);
    this.tell(true);
  }

  /** Moves a point that is here; moves with the same word are undone together. */
  move(name: string, mark: Mark, word: string): void {
    this.history.set(this.place.key, name, mark, word);
    this.tell(true);
  }

  settle(): void {
    this.history.settle();
  }

  remove(name: string | null): void {
    if (name === null || !this.own[name]) return;
    this.history.set(this.place.key, name, null);
    this.active = name;
    this.tell(true);
  }

  undo(): void {
    this.back(this.history.undo());
  }

  redo(): void {
    this.back(this.history.redo());
  }

  /** Pairs of points here whose left and right one seem to be exchanged. */
  get exchanged(): readonly (readonly [string, string])[] {
    if (this.place.kind === 'photograph') return exchanged(this.own, true);
    const located = Object.entries(this.own).flatMap(([name, mark]) => {
      const at = mark.vertex === undefined ? mark.at : this.pointOf?.(mark.vertex);
      return at ? [[name, { at }] as const] : [];
    });
    return exchanged(Object.fromEntries(located), false);
  }

  putRight(): void {
    this.history.replace(this.place.key, putRight(this.own, this.exchanged));
    this.tell(true);
  }

  /** How many photographs of a pose there are to place a point in; 1 on a surface. */
  private askedOf({ kind, pose }: Place): number {
    if (kind !== 'photograph') return 1;
    const all = this.task.places.filter((one) => one.kind === kind && one.pose === pose).length;
    return Math.min(this.task.asked, all);
  }

  private tell(placed: boolean): void {
    for (const one of this.heard) one(placed);
  }

  private back(key: string | null): void {
    if (key === null) return;
    this.current = this.task.places.findIndex((place) => place.key === key);
    if (this.active === null || this.own[this.active]) this.active = this.missing(null);
    this.tell(true);
  }

  /** The next point that is not here, and not yet in as many photographs as are asked for. */
  private missing(after: string | null, place: Place = this.place): string | null {
    const { names } = this.task;
    const from = after === null ? 0 : names.indexOf(after) + 1;
    const row = [...names.slice(from), ...names.slice(0, from)];
    const [own, asked] = [this.history.of(place.key), this.askedOf(place)];
    return row.find((name) => !own[name] && this.count(name, place) < asked) ?? null;
  }
}
