// Poses on this rig: which of its sliders their names mean, and a sentence about the rest.
import { numberOf } from '../../../shared/named';
import { matched } from '../../takes/matching';
import { isRotation } from '../../takes/names';
import type { NamedPose } from '../../types/state';
import type { Poses } from './list';

const SHOWN = 4;

export interface Fitted {
  readonly poses: NamedPose[];
  readonly unknown: string[]; // names that mean none of the sliders
}

/**
 * The poses by the sliders there are: names that the rig has are its own, others are matched as
 * those of a take.
 *
 * @throws Error with half a sentence where it is open which slider a name means
 */
export function fitted(poses: Poses, sliders: readonly string[]): Fitted {
  const names = [...new Set(poses.flatMap(({ weights }) => Object.keys(weights)))];
  const own = new Set(sliders);
  if (names.every((name) => own.has(name)))
    return { poses: poses.map((pose) => ({ ...pose, weights: nonZero(pose.weights) })), unknown: [] };
  const drives = matched(names, sliders);
  const used = new Set([...drives.values()].flat());
  return {
    poses: poses.map(({ name, weights }) => ({
      name,
      weights: nonZero(
        Object.fromEntries([...drives].map(([slider, by]) => [slider, mean(by, weights)])),
      ),
    })),
    unknown: names.filter((name) => !used.has(name) && !isRotation(name)),
  };
}

/** `a, b, c and 5 more` */
export function listed(names: readonly string[]): string {
  const rest = names.length - SHOWN;
  if (rest > 1) return `${names.slice(0, SHOWN).join(', ')} and ${rest} more`;
  return new Intl.ListFormat('en-GB').format(names);
}

function mean(names: readonly string[], weights: NamedPose['weights']): number {
  return names.reduce((sum, name) => sum + numberOf(weights, name), 0) / names.length;
}

function nonZero(weights: NamedPose['weights']): Record<string, number> {
  return Object.fromEntries(Object.entries(weights).filter(([, weight]) => weight !== 0));
}
