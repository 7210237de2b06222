// Marks and their past: every change can be undone and done again.
import type { Mark, Marks } from '../types/task';

interface Step {
  readonly before: Marks;
  readonly place: string;
  /** Changes in a row with the same word are one step, as while a point is dragged. */
  readonly word: string | null;
}

export class MarkHistory {
  private past: Step[] = [];
  private future: Step[] = [];

  constructor(private now: Marks) {}

  get marks(): Marks {
    return this.now;
  }

  get canUndo(): boolean {
    return this.past.length > 0;
  }

  get canRedo(): boolean {
    return this.future.length > 0;
  }

  of(place: string): Readonly<Record<string, Mark>> {
    return this.now[place] ?? {};
  }

  /** Puts a point where it is now, or takes it away. */
  set(place: string, name: string, mark: Mark | null, word: string | null = null): void {
    const own = { ...this.of(place) };
    if (mark) own[name] = mark;
    else delete own[name];
    this.replace(place, own, word);
  }

  /** Other marks for a whole place. */
  replace(place: string, own: Readonly<Record<string, Mark>>, word: string | null = null): void {
    const last = this.past.at(-1);
    if (!(word !== null && last?.word === word))
      this.past.push({ before: this.now, place, word });
    this.future = [];
    this.now = { ...this.now, [place]: own };
  }

  /** Ends what is one step. */
  settle(): void {
    const last = this.past.pop();
    if (last) this.past.push({ ...last, word: null });
  }

  /** Goes back a step; the place that changed, or null where there is no step. */
  undo(): string | null {
    return this.go(this.past, this.future);
  }

  redo(): string | null {
    return this.go(this.future, this.past);
  }

  private go(from: Step[], to: Step[]): string | null {
    const step = from.pop();
    if (!step) return null;
    to.push({ before: this.now, place: step.place, word: null });
    this.now = step.before;
    return step.place;
  }
}
