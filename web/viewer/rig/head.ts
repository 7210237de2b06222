// How the head of a performance is turned, as elastomorph.rig.performance.turning.
import { Euler, Quaternion } from 'three';
import type { Clip, Head } from '../types/model';
import { around } from './clips';

/** What the angles are called in takes, in any capitals. */
export const HEAD_ANGLES = ['HeadYaw', 'HeadPitch', 'HeadRoll'] as const;

/** How a head that looks along +Z with +Y up is turned. */
export function headRotation([yaw, pitch, roll]: Head): Quaternion {
  return new Quaternion().setFromEuler(new Euler(pitch, -yaw, -roll, 'YXZ'));
}

/** Yaw, pitch and roll of the head that a take was recorded with, where it was. */
export function headOf({ times, recorded, heads }: Clip, seconds: number): Head | null {
  if (!recorded && !heads) return null;
  const [before, end, share] = around(times, seconds);
  const angles = HEAD_ANGLES.map((angle, axis) => {
    const { names, weights } = recorded ?? { names: [], weights: [] };
    const column = names.findIndex((name) => name.toLowerCase() === angle.toLowerCase());
    const at = (frame: number) =>
      heads?.[frame]![axis] ?? weights[frame * names.length + column] ?? 0;
    return column < 0 && !heads ? 0 : at(before) + share * (at(end) - at(before));
  });
  return angles as unknown as Head;
}
