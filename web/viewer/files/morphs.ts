// How the morph targets of a file make up paths: as elastomorph described them in its extras, or
// each target a straight path of its own.
import type { BendCurve, Corrective, Model, Morph } from '../types/model';
import { isEntry, type Entry } from './document';

type Described = Pick<Model, 'morphs' | 'correctives' | 'groups'>;

const VERSION = 1;

/** The paths of a file; `stored` is `extras.elastomorph` of its mesh, if any. */
export function readMorphs(stored: unknown, targetNames: readonly string[]): Described {
  const described = isEntry(stored) ? describedBy(stored, targetNames) : null;
  if (described) return described;
  if (stored !== undefined) {
    console.warn(
      'What elastomorph stored beside the mesh does not fit it: each morph target is a slider.',
    );
  }
  return {
    morphs: targetNames.map((name, delta) => straight(name, delta)),
    correctives: [],
    groups: [],
  };
}

function straight(name: string, delta: number): Morph {
  return { name, method: 'linear', delta, bends: [] };
}

function describedBy(stored: Entry, targetNames: readonly string[]): Described | null {
  if (typeof stored['version'] !== 'number' || stored['version'] > VERSION) return null;
  const numberOf = new Map(targetNames.map((name, i) => [name, i]));
  const morphs: Morph[] = [];
  for (const entry of entries(stored, 'morphs')) {
    const morph = morphOf(entry, numberOf);
    if (!morph) return null;
    morphs.push(morph);
  }
  const used = new Set(
    morphs.flatMap(({ delta, bends }) => [delta, ...bends.map(({ target }) => target)]),
  );
  targetNames.forEach((name, i) => {
    if (!used.has(i)) morphs.push(straight(name, i));
  });
  const names = new Set(morphs.map(({ name }) => name));
  if (names.size !== morphs.length) return null;
  const correctives = lists(stored, 'correctives', 'drivers', names);
  const groups = lists(stored, 'groups', 'members', names);
  if (!correctives || !groups) return null;
  return {
    morphs,
    correctives: correctives.map(([name, drivers]): Corrective => ({ name, drivers })),
    groups: groups.map(([name, members]) => ({ name, members })),
  };
}

function morphOf(entry: Entry, numberOf: ReadonlyMap<unknown, number>): Morph | null {
  const delta = numberOf.get(entry['target']);
  const bends = entries(entry, 'bends').map((bend) => ({
    target: numberOf.get(bend['target']),
    curve: curveOf(bend['curve']),
  }));
  if (typeof entry['name'] !== 'string' || delta === undefined) return null;
  const found: Morph['bends'][number][] = [];
  for (const { target, curve } of bends) {
    if (target === undefined || !curve) return null;
    found.push({ target, curve });
  }
  const method = typeof entry['method'] === 'string' ? entry['method'] : 'linear';
  return { name: entry['name'], method, delta, bends: found };
}

function curveOf(stored: unknown): BendCurve | null {
  if (!isEntry(stored)) return null;
  const { breaks, coefficients } = stored;
  if (!isNumbers(breaks) || !Array.isArray(coefficients) || !coefficients.every(isNumbers))
    return null;
  const rises = breaks.every((time, i) => i === 0 || time > breaks[i - 1]!);
  if (!rises || breaks[0] !== 0 || breaks.at(-1) !== 1 || coefficients.length !== breaks.length - 1)
    return null;
  return { breaks, coefficients };
}

function isNumbers(value: unknown): value is number[] {
  return Array.isArray(value) && value.length > 0 && value.every((n) => Number.isFinite(n));
}

function entries(holder: Entry, key: string): Entry[] {
  const found = holder[key];
  return Array.isArray(found) ? found.filter(isEntry) : [];
}

function lists(
  stored: Entry,
  key: string,
  of: string,
  known: ReadonlySet<unknown>,
): [string, string[]][] | null {
  const found: [string, string[]][] = [];
  for (const entry of entries(stored, key)) {
    const members = entry[of];
    if (typeof entry['name'] !== 'string' || !Array.isArray(members)) return null;
    if (!members.every((name) => known.has(name))) return null;
    found.push([entry['name'], members as string[]]);
  }
  return found;
}
