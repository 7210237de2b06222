// What points in some photographs say of the same points in others, once cameras are known.
import type { Camera, Pixel, Point } from '../types/task';

export interface Sight {
  readonly camera: Camera;
  readonly pixel: Pixel;
}

const ROUNDS = 8;
const SAMPLES = 96;
const [NEAREST, FARTHEST] = [0.2, 5]; // of the distance to what the cameras look at

/** Where a camera sees a point; null behind it. */
export function project(camera: Camera, point: Point): Pixel | null {
  const [x, y, z] = turned(camera, point);
  if (!(z > 0)) return null;
  const [a, b] = [x / z, y / z];
  const stretch = camera.focal * (1 + camera.radial * (a * a + b * b));
  return [stretch * a + camera.centre[0], stretch * b + camera.centre[1]];
}

/** Where a camera stands. */
export function position({ rotation: r, translation: t }: Camera): Point {
  return [0, 1, 2].map(
    (i) => -(r[i]! * t[0] + r[3 + i]! * t[1] + r[6 + i]! * t[2]),
  ) as unknown as Point;
}

/** Direction of length 1 from the camera through a pixel. */
export function direction(camera: Camera, pixel: Pixel): Point {
  const goal = [0, 1].map((i) => (pixel[i]! - camera.centre[i]!) / camera.focal) as [
    number,
    number,
  ];
  let [a, b] = goal;
  for (let round = 0; round < 20; round += 1) {
    const stretch = 1 + camera.radial * (a * a + b * b);
    [a, b] = [goal[0] / stretch, goal[1] / stretch];
  }
  const r = camera.rotation;
  const along = [0, 1, 2].map((i) => r[i]! * a + r[3 + i]! * b + r[6 + i]!);
  const length = Math.hypot(...along);
  return along.map((value) => value / length) as unknown as Point;
}

/** The point that is seen at given pixels, with the least squared distance to them; null if none. */
export function triangulated(sights: readonly Sight[]): Point | null {
  if (sights.length < 2) return null;
  let point = nearestToRays(
    sights.map(({ camera, pixel }) => [position(camera), direction(camera, pixel)] as const),
  );
  for (let round = 0; point && round < ROUNDS; round += 1) point = improved(point, sights);
  return point && sights.every(({ camera }) => project(camera, point)) ? point : null;
}

/** What is seen in the middle of all photographs. */
export function lookedAt(cameras: readonly Camera[]): Point | null {
  return nearestToRays(
    cameras.map((camera) => [position(camera), direction(camera, camera.centre)] as const),
  );
}

/** Where a point seen by another camera may be in the photograph of `here`: pixels in a row. */
export function lineOfSight(from: Sight, here: Camera, middle: Point): Pixel[] {
  const eye = position(from.camera);
  const along = direction(from.camera, from.pixel);
  const distance = Math.hypot(...eye.map((value, i) => middle[i]! - value));
  const found: Pixel[] = [];
  for (let i = 0; i <= SAMPLES; i += 1) {
    const share = i / SAMPLES;
    const depth = distance / ((1 - share) / NEAREST + share / FARTHEST);
    const pixel = project(here, eye.map((value, k) => value + depth * along[k]!) as never);
    if (pixel) found.push(pixel);
  }
  return found;
}

function turned({ rotation: r, translation: t }: Camera, p: Point): Point {
  return [0, 3, 6].map(
    (i, k) => r[i]! * p[0] + r[i + 1]! * p[1] + r[i + 2]! * p[2] + t[k]!,
  ) as unknown as Point;
}

/** Least sum of squared distances to rays: Σ (1 − d dᵀ)(x − o) = 0. */
function nearestToRays(rays: readonly (readonly [Point, Point])[]): Point | null {
  const matrix = new Array<number>(9).fill(0);
  const goal = [0, 0, 0];
  for (const [from, along] of rays) {
    for (let i = 0; i < 3; i += 1) {
      for (let k = 0; k < 3; k += 1) {
        const entry = (i === k ? 1 : 0) - along[i]! * along[k]!;
        matrix[3 * i + k]! += entry;
        goal[i]! += entry * from[k]!;
      }
    }
  }
  return solved(matrix, goal);
}

/** One step of Gauss and Newton on the distances in pixels. */
function improved(point: Point, sights: readonly Sight[]): Point | null {
  const matrix = new Array<number>(9).fill(0);
  const goal = [0, 0, 0];
  const step = 1e-5 * Math.hypot(...point.map((value, i) => value - position(sights[0]!.camera)[i]!));
  for (const { camera, pixel } of sights) {
    const now = project(camera, point);
    if (!now) return null;
    const slopes = [0, 1, 2].map((axis) => {
      const moved = point.map((value, i) => value + (i === axis ? step : 0)) as unknown as Point;
      const then = project(camera, moved) ?? now;
      return [(then[0] - now[0]) / step, (then[1] - now[1]) / step] as const;
    });
    for (let c = 0; c < 2; c += 1) {
      const left = pixel[c]! - now[c]!;
      for (let i = 0; i < 3; i += 1) {
        goal[i]! += slopes[i]![c]! * left;
        for (let k = 0; k < 3; k += 1) matrix[3 * i + k]! += slopes[i]![c]! * slopes[k]![c]!;
      }
    }
  }
  const change = solved(matrix, goal);
  return change && (point.map((value, i) => value + change[i]!) as unknown as Point);
}

/** Solution of three symmetric equations by Cramer's rule; null where there is not one. */
function solved(m: readonly number[], g: readonly number[]): Point | null {
  const column = (i: number): Point => [m[i]!, m[3 + i]!, m[6 + i]!];
  const columns = [column(0), column(1), column(2)] as const;
  const whole = determinant(...columns);
  const size = Math.abs(m[0]!) + Math.abs(m[4]!) + Math.abs(m[8]!);
  if (!(Math.abs(whole) > 1e-12 * size ** 3)) return null;
  return [0, 1, 2].map((i) => {
    const replaced = columns.map((own, k) => (k === i ? (g as unknown as Point) : own));
    return determinant(replaced[0]!, replaced[1]!, replaced[2]!) / whole;
  }) as unknown as Point;
}

export function determinant(a: Point, b: Point, c: Point): number {
  return (
    a[0] * (b[1] * c[2] - b[2] * c[1]) -
    a[1] * (b[0] * c[2] - b[2] * c[0]) +
    a[2] * (b[0] * c[1] - b[1] * c[0])
  );
}
