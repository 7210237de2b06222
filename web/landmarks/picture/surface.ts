// A surface, turned and moved in parallel projection, and what is clicked on it.
import { cast, cornerNear, vertexAt, type Mesh } from '../geometry/mesh';
import type { Mark, Point } from '../types/task';
import { Painter, type SurfaceView } from './paint';
import type { Pane, Spot } from './pane';

const MARGIN = 0.9;
const NEAR = 8; // times the picture from which a surface needs no magnifier
const TURN = Math.PI / 500; // a CSS pixel
const FRONT = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const QUICK = 2_000_000; // triangles that are tested within a frame
const NEARER = 0.01; // of the size: a corner of the eye is not hidden by lashes before it

export class SurfacePane implements Pane {
  readonly canvas = document.createElement('canvas');
  private readonly painter: Painter;
  private view: SurfaceView = { turn: FRONT, fits: true, scale: 1, x: 0, y: 0 };
  private width = 1;
  private height = 1;
  private ratio = 1;
  private grabbed: Point | null = null;
  private readonly seen = new Map<string, boolean>();
  private readonly size: number;
  clay = false;
  edges: boolean;

  /**
   * @param snaps whether clicks find vertices, as on a template
   * @param view from where it was looked at before, if it was
   */
  constructor(
    readonly mesh: Mesh,
    images: readonly (ImageBitmap | null)[],
    private readonly snaps: boolean,
    view: SurfaceView | null,
  ) {
    this.painter = new Painter(this.canvas, mesh, images);
    this.edges = snaps;
    if (view) this.view = view;
    this.size = Math.hypot(...mesh.high.map((value, i) => value - mesh.low[i]!)) || 1;
  }

  get near(): boolean {
    return this.view.scale * this.size > NEAR * Math.max(this.width, this.height);
  }

  get hovers(): boolean {
    return this.mesh.triangles.length < QUICK;
  }

  resize(width: number, height: number, ratio: number): void {
    Object.assign(this, { width, height, ratio });
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    if (this.view.fits) this.fit();
  }

  fit(): void {
    const { low, high } = this.mesh;
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) =>
      this.turned([i & 1 ? low[0] : high[0], i & 2 ? low[1] : high[1], i & 4 ? low[2] : high[2]]),
    );
    const [xs, ys] = [corners.map(([x]) => x), corners.map(([, y]) => y)];
    const [left, right] = [Math.min(...xs), Math.max(...xs)];
    const [bottom, top] = [Math.min(...ys), Math.max(...ys)];
    const scale =
      MARGIN * Math.min(this.width / (right - left || 1), this.height / (top - bottom || 1));
    this.view = {
      ...this.view,
      fits: true,
      scale,
      x: (-scale * (left + right)) / 2,
      y: (scale * (bottom + top)) / 2,
    };
  }

  /** From the front again. */
  actual(): void {
    this.turnTo(FRONT);
    this.fit();
  }

  zoom(factor: number, x: number, y: number): void {
    const { view } = this;
    const most = (60 * Math.max(this.width, this.height)) / this.size;
    const scale = Math.min(Math.max(view.scale * factor, most / 300), most);
    const share = scale / view.scale;
    const [right, down] = this.fromMiddle(x, y);
    const [x1, y1] = [right - share * (right - view.x), down - share * (down - view.y)];
    this.view = { ...view, fits: false, scale, x: x1, y: y1 };
  }

  get looked(): SurfaceView {
    return this.view;
  }

  /** What is taken hold of stays under the pointer while the surface turns. */
  grab(x: number, y: number): void {
    this.grabbed = this.met(x, y)?.at ?? null;
  }

  release(): void {
    this.grabbed = null;
  }

  drag(dx: number, dy: number, move: boolean): void {
    if (move) {
      this.view = { ...this.view, fits: false, x: this.view.x + dx, y: this.view.y + dy };
      return;
    }
    const middle = this.mesh.low.map((value, i) => (value + this.mesh.high[i]!) / 2);
    const pivot = this.grabbed ?? (middle as unknown as Point);
    const [x, y] = this.screen(pivot);
    this.turnTo(multiplied(rotation(TURN * dx, TURN * dy), this.view.turn));
    const [u, v] = this.screen(pivot);
    this.view = { ...this.view, fits: false, x: this.view.x + x - u, y: this.view.y + y - v };
  }

  spot(mark: Mark): Spot | null {
    const at = this.place(mark);
    if (!at) return null;
    const [x, y] = this.screen(at);
    return { x, y, hidden: !this.visible(at) };
  }

  pick(x: number, y: number): Mark | null {
    const met = this.met(x, y);
    if (!met) return null;
    if (!this.snaps) return { at: met.at.map((value, i) => value + this.mesh.origin[i]!) };
    const corner = cornerNear(this.mesh, met);
    return { at: vertexAt(this.mesh, corner), vertex: this.mesh.sources[corner]! };
  }

  nudged(mark: Mark, dx: number, dy: number): Mark | null {
    const at = this.place(mark);
    if (!at) return null;
    const [x, y] = this.screen(at);
    // A vertex is left only for another one: as far as it takes.
    for (let step = 1; step < 80; step += 1) {
      const found = this.pick(x + step * dx, y + step * dy);
      if (!found || found.vertex === undefined || found.vertex !== mark.vertex) return found;
    }
    return null;
  }

  draw(): void {
    this.painter.draw(this.view, this.width, this.height, this.ratio, this);
  }

  magnify(context: CanvasRenderingContext2D, x: number, y: number, size: number): void {
    const { view } = this;
    const [right, down] = this.fromMiddle(x, y);
    const nearer = { ...view, scale: 4 * view.scale, x: 4 * (view.x - right), y: 4 * (view.y - down) };
    this.painter.draw(nearer, size, size, this.ratio, this);
    const side = Math.round(size * this.ratio);
    context.drawImage(this.canvas, 0, this.canvas.height - side, side, side, 0, 0, side, side);
  }

  dispose(): void {
    this.painter.dispose();
  }

  /** Where a vertex of the author's is; null where there is none. */
  point(vertex: number): Point | null {
    const own = this.mesh.own.get(vertex);
    return own === undefined ? null : vertexAt(this.mesh, own);
  }

  /** Without the origin; null for a vertex that the surface does not have. */
  private place({ at, vertex }: Mark): Point | null {
    const own = vertex === undefined ? undefined : this.mesh.own.get(vertex);
    if (own !== undefined) return [...this.mesh.positions.subarray(3 * own, 3 * own + 3)] as never;
    if (vertex !== undefined || at.length < 3) return null;
    return at.map((value, i) => value - this.mesh.origin[i]!) as unknown as Point;
  }

  private met(x: number, y: number) {
    const { view } = this;
    const [right, down] = this.fromMiddle(x, y);
    const q: Point = [(right - view.x) / view.scale, (view.y - down) / view.scale, 2 * this.size];
    return cast(this.mesh, this.back(q), this.back([0, 0, -1]));
  }

  private visible(at: Point): boolean {
    const key = at.join();
    const known = this.seen.get(key);
    if (known !== undefined) return known;
    if (this.grabbed && 15 * this.mesh.triangles.length > QUICK) return true;
    const way = this.back([0, 0, 1]);
    const eye = at.map((value, i) => value + NEARER * this.size * way[i]!) as unknown as Point;
    const free = cast(this.mesh, eye, way) === null;
    this.seen.set(key, free);
    return free;
  }

  private turnTo(turn: readonly number[]): void {
    this.view = { ...this.view, turn };
    this.seen.clear();
  }

  private fromMiddle(x: number, y: number): readonly [number, number] {
    return [x - this.width / 2, y - this.height / 2];
  }

  private screen(p: Point): [number, number] {
    const [x, y] = this.turned(p);
    const { view, width, height } = this;
    return [width / 2 + view.x + view.scale * x, height / 2 + view.y - view.scale * y];
  }

  private turned(p: Point): Point {
    const { turn: r } = this.view;
    return [0, 3, 6].map((i) => r[i]! * p[0] + r[i + 1]! * p[1] + r[i + 2]! * p[2]) as never;
  }

  private back(p: Point): Point {
    const { turn: r } = this.view;
    return [0, 1, 2].map((i) => r[i]! * p[0] + r[3 + i]! * p[1] + r[6 + i]! * p[2]) as never;
  }
}

/** About the vertical of the screen, then about its horizontal. */
function rotation(across: number, down: number): number[] {
  const [c, s] = [Math.cos(across), Math.sin(across)];
  const [d, t] = [Math.cos(down), Math.sin(down)];
  return multiplied([1, 0, 0, 0, d, -t, 0, t, d], [c, 0, s, 0, 1, 0, -s, 0, c]);
}

function multiplied(a: readonly number[], b: readonly number[]): number[] {
  return Array.from({ length: 9 }, (_, i) =>
    [0, 1, 2].reduce((sum, k) => sum + a[3 * Math.floor(i / 3) + k]! * b[3 * k + (i % 3)]!, 0),
  );
}
