// Poses by the processor, for browsers that cannot draw into textures of floats.
import type { DataTexture } from 'three';
import { texelsOf, type Texels } from '../rig/layout';
import type { ActiveTarget } from '../rig/pose';
import { poseInto } from '../rig/surface';
import type { Model } from '../types/model';
import { ringsOf, type Rings } from './rings';
import type { Poser, Shape } from './shape';
import { numberTexture } from './textures';

interface HeldShape extends Shape {
  readonly positions: DataTexture;
  readonly normals: DataTexture;
  readonly own: Float32Array; // (V, 3)
}

export class CpuPoser implements Poser {
  readonly gpu = false;
  readonly bytes = 0;
  readonly bytesOfShape: number;
  private readonly texels: Texels;
  private readonly rings: Rings;

  constructor(private readonly model: Model) {
    this.texels = texelsOf(model.neutral.length / 3);
    this.bytesOfShape = 2 * 16 * this.texels.width * this.texels.rows;
    this.rings = ringsOf(model);
  }

  shape(): HeldShape {
    const { width, rows } = this.texels;
    const texture = () => numberTexture(new Float32Array(4 * width * rows), width, rows, 'RGBA32F');
    const [positions, normals] = [texture(), texture()];
    const own = new Float32Array(this.model.neutral.length);
    const dispose = () => [positions, normals].forEach((t) => t.dispose());
    return { positions, normals, own, dispose };
  }

  pose(shape: Shape, active: readonly ActiveTarget[]): void {
    const { own, positions, normals } = shape as HeldShape;
    poseInto(own, this.model, active);
    const four = positions.image.data as Float32Array;
    for (let v = 0; v < own.length / 3; v += 1) four.set(own.subarray(3 * v, 3 * v + 3), 4 * v);
    this.normalsInto(normals.image.data as Float32Array, own);
    positions.needsUpdate = true;
    normals.needsUpdate = true;
  }

  read(shape: Shape): Float32Array {
    return (shape as HeldShape).own.slice();
  }

  dispose(): void {}

  /** The same sums as the shader that finds normals on the graphics card. */
  private normalsInto(out: Float32Array, at: Float32Array): void {
    const { ofVertex, corners } = this.rings;
    for (let v = 0; v < at.length / 3; v += 1) {
      const [start, count] = [ofVertex[2 * v]!, ofVertex[2 * v + 1]!];
      const sum: Sum = [0, 0, 0];
      const around: Sum = [0, 0, 0];
      let reach = 0;
      for (let c = start; c < start + count; c += 1) {
        const after = difference(at, corners[2 * c]!, v);
        const before = difference(at, corners[2 * c + 1]!, v);
        const area = cross(after, before);
        const size = Math.hypot(...area);
        const share = size > 0 ? Math.atan2(size, dot(after, before)) / size : 0;
        reach += Math.hypot(...after) + Math.hypot(...before);
        for (const axis of [0, 1, 2] as const) {
          sum[axis] += share * area[axis];
          around[axis] += after[axis] + before[axis];
        }
      }
      const size = Math.hypot(...sum);
      const normal =
        size > 1e-9
          ? ([sum[0] / size, sum[1] / size, sum[2] / size] as const)
          : ([0, 0, 1] as const);
      out.set(normal, 4 * v);
      out[4 * v + 3] = reach > 0 ? dot(normal, around) / reach : 0;
    }
  }
}

type Sum = [number, number, number];
type Vector = readonly [number, number, number];

function difference(at: Float32Array, one: number, other: number): Vector {
  return [
    at[3 * one]! - at[3 * other]!,
    at[3 * one + 1]! - at[3 * other + 1]!,
    at[3 * one + 2]! - at[3 * other + 2]!,
  ];
}

function cross(a: Vector, b: Vector): Vector {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function dot(a: Vector, b: Vector): number {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
