// What a picture is, of a photograph or of a surface: something to move about in and to click on.
import type { Mark } from '../types/task';

export interface Spot {
  readonly x: number; // CSS pixels from the corner of the picture
  readonly y: number;
  /** Behind the surface, as seen from here. */
  readonly hidden: boolean;
}

export interface Pane {
  readonly canvas: HTMLCanvasElement;
  /** Whether it is large enough to be clicked on without a magnifier. */
  readonly near: boolean;
  /** Whether what is under the pointer is found and shown at every move of it. */
  readonly hovers: boolean;
  /** The picture is so large now, in CSS pixels, with so many device pixels for each. */
  resize(width: number, height: number, ratio: number): void;
  draw(): void;
  /** All of it in the picture. */
  fit(): void;
  /** One pixel of the photograph for one of the screen; a surface from the front. */
  actual(): void;
  zoom(factor: number, x: number, y: number): void;
  /** Somebody takes hold of what is under a point of the picture, and later lets it go. */
  grab(x: number, y: number): void;
  release(): void;
  /** Follows the pointer: turns a surface, unless `move` says otherwise; moves a photograph. */
  drag(dx: number, dy: number, move: boolean): void;
  /** Where a mark is in the picture; null where it is not in it at all. */
  spot(mark: Mark): Spot | null;
  /** What is under a point of the picture. */
  pick(x: number, y: number): Mark | null;
  /** The mark so much farther right and down: pixels of a photograph, or of the screen. */
  nudged(mark: Mark, dx: number, dy: number): Mark | null;
  /** Draws what is around a point of the picture, enlarged, into a square of the context. */
  magnify(context: CanvasRenderingContext2D, x: number, y: number, size: number): void;
}

// Marks are put down to a hundredth of a pixel, which is more than anybody clicks at.
export function rounded(value: number): number {
  return Math.round(100 * value) / 100;
}
