// How long frames take, and how many there are a second while something moves.

const KEPT = 40;
const STILL = 400; // milliseconds without a frame after which nothing moves

export class Pace {
  private readonly costs: number[] = [];
  private readonly starts: number[] = [];

  add(start: number, cost: number): void {
    if (start - (this.starts.at(-1) ?? start) > STILL) this.starts.length = 0;
    this.starts.push(start);
    this.costs.push(cost);
    if (this.starts.length > KEPT) this.starts.shift();
    if (this.costs.length > KEPT) this.costs.shift();
  }

  get milliseconds(): number {
    return this.costs.reduce((sum, cost) => sum + cost, 0) / Math.max(1, this.costs.length);
  }

  get framesPerSecond(): number | null {
    const [first, last] = [this.starts[0], this.starts.at(-1)];
    if (
      first === undefined ||
      last === undefined ||
      last <= first ||
      performance.now() - last > STILL
    )
      return null;
    return (1000 * (this.starts.length - 1)) / (last - first);
  }
}
