// What the interface asks of the stage, and what it hears back.
import type { Head, Model } from './model';
import type { ViewState } from './state';

export type View = 'front' | 'three-quarter' | 'side' | 'below';

/**
 * Where a face is seen from, whatever its size: the turn to the right and upwards in degrees, and
 * in diagonals of the box round the face the distance, and what is looked at from its middle.
 */
export type Place = readonly [
  ...[turn: number, lift: number, distance: number],
  ...[x: number, y: number, z: number],
];
/** A place of the canvas, in CSS pixels. */
export interface Spot {
  readonly x: number;
  readonly y: number;
  readonly drawn: boolean; // whether the model is drawn there
}

export type Position = readonly [number, number, number];

/** A vertex under the pointer. */
export interface Pick {
  readonly model: number;
  readonly vertex: number;
  readonly position: Position;
  /** Distance from the model compared against, in the unit of the model; null without one. */
  readonly distance: number | null;
}

/** Distances from `against` of the shown model that is farthest from it. */
export interface HeatReadout {
  readonly model: number;
  readonly largest: number; // in the unit of the model
  readonly mean: number;
  readonly worstVertex: number;
  readonly top: number; // distance of the last colour
}

export interface Readout {
  readonly frameMilliseconds: number; // mean of the last frames drawn, main thread
  readonly framesPerSecond: number | null; // while something moves
  readonly targets: number; // morph targets whose weight is not 0, of all models shown
  readonly mebibytes: number; // on the graphics card, of all models
  readonly gpu: boolean; // false: posed by the processor, for want of float render targets
  readonly heat: HeatReadout | null;
}

export interface Stage {
  /** Replaces everything shown. Throws an Error with a message for people. */
  setModels(models: readonly Model[]): void;
  /** Draws the state, soon; many calls in one frame are one drawing. */
  show(state: ViewState): void;
  /** How the head of the phone is turned, drawn with its next pose. */
  turnHead(head: Head): void;
  /**
   * Draws now, and returns when it is drawn; as a picture at rest, unless what moves may be drawn
   * in less time.
   */
  flush(atRest?: boolean): void;
  /** (V, 3) positions of a model under the state shown last, read back from the graphics card. */
  positions(model: number): Float32Array;
  /** The visible vertex nearest to a point of the canvas, in CSS pixels; null beside the face. */
  pick(x: number, y: number): Pick | null;
  /** Where a point of a model is seen; null where the model is not shown. */
  spot(model: number, position: ArrayLike<number>): Spot | null;
  /** What is under a place of the canvas in the plane through a point, parallel to the picture. */
  across(model: number, position: ArrayLike<number>, x: number, y: number): Position;
  /** From where the faces are seen. */
  eye(): Position;
  /** Calls back after each drawing. */
  drawn(listener: () => void): void;
  readout(): Readout;
  /** Turns to a view and fits the face into it. */
  look(view: View): void;
  /** The view that was turned to, or where the camera has gone since. */
  camera(): View | Place;
  goTo(place: Place): void;
  /** A small picture of an expression of the first face shown, from the front. */
  portrait(weights: ViewState['weights']): HTMLCanvasElement;
  /** Turns the camera round the face by angles in radians, for keys. */
  turn(azimuth: number, elevation: number): void;
  /** Moves the camera nearer (factor > 1) or farther. */
  zoom(factor: number): void;
  /** Colours of the background and lines follow the theme of the page. */
  setDark(dark: boolean): void;
  dispose(): void;
}
