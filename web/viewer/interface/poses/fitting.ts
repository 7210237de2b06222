// Poses on this rig: what its sliders know of them, and a sentence about the rest.
import type { NamedPose } from '../../types/state';
import type { Poses } from './list';

const SHOWN = 4;

/** The poses by the sliders there are, and the names that none of them has. */
export function fitted(
  poses: Poses,
  sliders: readonly string[],
): { readonly poses: NamedPose[]; readonly unknown: string[] } {
  const known = new Set(sliders);
  const unknown = new Set<string>();
  const own = poses.map(({ name, weights }) => ({
    name,
    weights: Object.fromEntries(
      Object.entries(weights).filter(([slider, weight]) => {
        if (!known.has(slider)) unknown.add(slider);
        return known.has(slider) && weight !== 0;
      }),
    ),
  }));
  return { poses: own, unknown: [...unknown] };
}

/** `a, b, c and 5 more` */
export function listed(names: readonly string[]): string {
  const rest = names.length - SHOWN;
  if (rest > 1) return `${names.slice(0, SHOWN).join(', ')} and ${rest} more`;
  return names.length < 2 ? names.join() : `${names.slice(0, -1).join(', ')} and ${names.at(-1)}`;
}
