// Which weights of a recording drive which sliders: as elastomorph.rig.performance.matching.
import { isRotation, nodeOf, shapeOf, WHOLES } from './names';

/** The weights whose mean drives a slider, for each slider that is driven. */
export type Drives = ReadonlyMap<string, readonly string[]>;

/**
 * Equal shapes first, whatever their spelling. Of what is left, one weight for both sides drives
 * each side, and both sides drive one slider for both by their mean.
 *
 * @throws Error with half a sentence where it is open which of two names is meant
 */
export function matched(weights: readonly string[], sliders: readonly string[]): Drives {
  const recorded = byShape(
    weights.filter((name) => !isRotation(name)),
    'take',
  );
  const onRig = byShape(
    sliders.filter((name) => !isRotation(name)),
    'rig',
    new Set(weights),
  );
  const drives = new Map<string, readonly string[]>();
  const used = new Set<string>();
  const drive = (shape: string, by: readonly string[]) => {
    const driven = onRig.get(shape) ?? [];
    for (const slider of driven) drives.set(slider, by);
    onRig.delete(shape);
    return driven.length > 0;
  };
  for (const [shape, [name]] of recorded) if (drive(shape, [name!])) used.add(shape);
  for (const [whole, parts] of WHOLES) {
    if (recorded.has(whole) && !used.has(whole)) {
      const name = recorded.get(whole)![0]!;
      if (parts.map((part) => drive(part, [name])).some(Boolean)) used.add(whole);
    } else if (onRig.has(whole) && parts.every((part) => recorded.has(part) && !used.has(part))) {
      drive(
        whole,
        parts.map((part) => recorded.get(part)![0]!),
      );
      for (const part of parts) used.add(part);
    }
  }
  const driven = sliders.flatMap((slider) => {
    const by = drives.get(slider);
    return by ? [[slider, by] as const] : [];
  });
  return new Map(driven);
}

/** The names of each shape; several nodes of a rig may each have it once. */
function byShape(
  names: readonly string[],
  kind: 'take' | 'rig',
  preferred: ReadonlySet<string> = new Set(),
): Map<string, string[]> {
  const found = new Map<string, Map<string, string[]>>();
  for (const name of names) {
    const shape = shapeOf(name) ?? name;
    const node = kind === 'rig' ? nodeOf(name) : '';
    const nodes = found.get(shape) ?? new Map<string, string[]>();
    found.set(shape, nodes.set(node, [...(nodes.get(node) ?? []), name]));
  }
  const only = (shape: string, same: readonly string[]): string => {
    const exact = same.length > 1 ? same.filter((name) => preferred.has(name)) : same;
    if (exact.length === 1) return exact[0]!;
    throw new Error(
      `the ${kind} has ${same.join(' and ')}, which are both ${shape}; rename one of them`,
    );
  };
  return new Map(
    [...found].map(([shape, nodes]) => [
      shape,
      [...nodes.values()].map((same) => only(shape, same)),
    ]),
  );
}
