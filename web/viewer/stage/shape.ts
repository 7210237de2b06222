// A shape of a face on the graphics card: where each vertex is, and its normal.
import type { Texture } from 'three';
import type { ActiveTarget } from '../rig/pose';

export interface Shape {
  readonly positions: Texture;
  readonly normals: Texture;
  dispose(): void;
}

/** Makes shapes of one model. */
export interface Poser {
  readonly gpu: boolean;
  /** Bytes of what all shapes share. */
  readonly bytes: number;
  readonly bytesOfShape: number;
  shape(): Shape;
  /** Writes the neutral moved by some morph targets into a shape. */
  pose(shape: Shape, active: readonly ActiveTarget[]): void;
  /** (V, 3) positions of a shape. */
  read(shape: Shape): Float32Array;
  dispose(): void;
}
