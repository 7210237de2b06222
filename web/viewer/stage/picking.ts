// Which vertex is under a point of the picture.
import { Vector3, type PerspectiveCamera } from 'three';
import type { Model } from '../types/model';
import { isThere } from './opacity';

/**
 * The corner nearest to the ray of the first triangle that it meets.
 *
 * @param at place in the picture, −1 to 1 rightwards and upwards
 */
export function pickVertex(
  model: Model,
  positions: Float32Array,
  camera: PerspectiveCamera,
  at: readonly [number, number],
): number | null {
  const eye = camera.position;
  const ray = new Vector3(at[0], at[1], 0.5).unproject(camera).sub(eye).normalize();
  const triangle = firstTriangle(model, positions, eye, ray);
  if (triangle === null) return null;
  let nearest: number | null = null;
  let least = Infinity;
  for (let c = 0; c < 3; c += 1) {
    const vertex = model.triangles[triangle + c]!;
    const from = new Vector3().fromArray(positions, 3 * vertex).sub(eye);
    const aside = from.cross(ray).lengthSq();
    if (aside < least) [least, nearest] = [aside, vertex];
  }
  return nearest === null ? null : model.seams[nearest]!;
}

/** Möller and Trumbore's test over all triangles that are drawn: two milliseconds for 50,000. */
function firstTriangle(
  model: Model,
  p: Float32Array,
  eye: Vector3,
  ray: Vector3,
): number | null {
  let found: number | null = null;
  let nearest = Infinity;
  const { x: dx, y: dy, z: dz } = ray;
  const { triangles } = model;
  for (const part of model.parts) {
    const { start, count, shown, skin } = part;
    if (!shown) continue;
    const least = skin && !skin.doubleSided ? 0 : -Infinity;
    for (let i = start; i < start + count; i += 3) {
      const [a, b, c] = [3 * triangles[i]!, 3 * triangles[i + 1]!, 3 * triangles[i + 2]!];
      const [ux, uy, uz] = [p[b]! - p[a]!, p[b + 1]! - p[a + 1]!, p[b + 2]! - p[a + 2]!];
      const [vx, vy, vz] = [p[c]! - p[a]!, p[c + 1]! - p[a + 1]!, p[c + 2]! - p[a + 2]!];
      const [hx, hy, hz] = [dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx];
      const area = ux * hx + uy * hy + uz * hz;
      if (area === 0 || area < least) continue; // or its back, which is not drawn
      const [sx, sy, sz] = [eye.x - p[a]!, eye.y - p[a + 1]!, eye.z - p[a + 2]!];
      const u = (sx * hx + sy * hy + sz * hz) / area;
      if (u < 0 || u > 1) continue;
      const [qx, qy, qz] = [sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux];
      const v = (dx * qx + dy * qy + dz * qz) / area;
      if (v < 0 || u + v > 1) continue;
      const away = (vx * qx + vy * qy + vz * qz) / area;
      if (away > 0 && away < nearest && isThere(model, part, i, u, v)) [nearest, found] = [away, i];
    }
  }
  return found;
}
