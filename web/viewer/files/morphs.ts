// How the morph targets of a file make up paths: as elastomorph described them in its extras, or
// each target a straight path of its own.
import { Bender, type DescribedMorph, type MeshExtras } from '../../../runtimes/js/index.js';
import type { Model, Morph } from '../types/model';
import { type Entry, isEntry } from './document';

type Described = Pick<Model, 'morphs' | 'groups' | 'bender' | 'sliders'>;
type Stored = NonNullable<MeshExtras['elastomorph']> & {
  readonly groups?: Model['groups'];
  /** Of the first of the meshes that one surface is stored as. */
  readonly whole?: { readonly targets?: readonly string[]; readonly groups?: Model['groups'] };
};

/** What has a place among the targets: its own, or the first of its bends. */
interface Placed {
  readonly target?: string;
  readonly bends?: readonly { readonly target: string }[];
}

/** The paths of a file; `stored` is `extras.elastomorph` of each mesh that has it. */
export function readMorphs(stored: readonly unknown[], targetNames: readonly string[]): Described {
  try {
    if (stored.length > 0) return described(joined(stored as Stored[]), targetNames);
  } catch (error) {
    console.warn(
      'What elastomorph stored beside the mesh does not fit it: each morph target is a slider.',
      error,
    );
  }
  return described({ version: 1 }, targetNames);
}

function described(stored: Stored, targetNames: readonly string[]): Described {
  const bender = new Bender({ elastomorph: stored }, targetNames); // refuses what does not fit
  const { morphs = [], groups = [] } = stored;
  const used = new Set(
    morphs.flatMap(({ target, bends = [] }) => [target, ...bends.map((bend) => bend.target)]),
  );
  const numberOf = new Map(targetNames.map((name, i) => [name, i]));
  const paths = morphs.flatMap((morph) => path(morph, numberOf, stored.version));
  targetNames.forEach((name, delta) => {
    if (!used.has(name)) paths.push({ name, delta, fold: null });
  });
  const names = new Set(paths.map(({ name }) => name));
  const fit = groups.filter(({ members }) => members?.every((name) => names.has(name)));
  return { morphs: paths, groups: fit, bender, sliders: bender.sliders };
}

/** The path to the target of a morph; none where it has bends alone. */
function path(
  { name, target, fold }: DescribedMorph,
  numberOf: ReadonlyMap<string, number>,
  version: number,
): Morph | [] {
  if (target === undefined) return [];
  const delta = numberOf.get(target)!;
  if (!fold || version < 2) return { name, delta, fold: null };
  const alone = { version, morphs: [{ name, target, fold }] };
  const own = new Bender({ elastomorph: alone }, [target]);
  const weight = [0];
  return { name, delta, fold: (t) => own.weights([t], weight)[0]! };
}

/** What several meshes say of the one face they are: the same, each of its own targets. */
function joined(stored: readonly Stored[]): Stored {
  const first = stored[0]!;
  if (stored.length === 1) return first;
  const morphs = new Map<string, DescribedMorph>();
  for (const { morphs: own = [] } of stored) {
    for (const morph of own) {
      const known = morphs.get(morph.name);
      const bends = new Map(known?.bends?.map((bend) => [bend.target, bend]));
      for (const bend of morph.bends ?? []) {
        requireSame(bends.get(bend.target) ?? bend, bend);
        bends.set(bend.target, bend);
      }
      if (known) requireSame([known.target, known.fold], [morph.target, morph.fold]);
      morphs.set(morph.name, { ...morph, bends: [...bends.values()] });
    }
  }
  const { targets = [], groups = [] } = first.whole ?? {};
  const order = new Map(targets.map((target, i) => [target, i]));
  const place = ({ target, bends = [] }: Placed): number =>
    target === undefined ? Math.min(...bends.map(place)) : (order.get(target) ?? Infinity);
  const rises = (a: Placed, b: Placed) => place(a) - place(b) || 0;
  return {
    version: Math.max(...stored.map(({ version }) => version)),
    morphs: [...morphs.values()]
      .sort(rises)
      .map((morph) => ({ ...morph, bends: [...(morph.bends ?? [])].sort(rises) })),
    correctives: byName(stored.flatMap(({ correctives = [] }) => correctives)),
    groups: byName([...groups, ...stored.flatMap((own) => own.groups ?? [])]),
  };
}

function byName<Named extends { readonly name: string }>(entries: readonly Named[]): Named[] {
  return [...new Map(entries.map((entry) => [entry.name, entry])).values()];
}

function requireSame(one: unknown, other: unknown): void {
  if (JSON.stringify(one) !== JSON.stringify(other))
    throw new Error('two meshes say different things of one path');
}

/**
 * `extras.elastomorph` of each of some meshes, where it has any. A target that is told by its number
 * gets the name of its own that `namesOf` gives it.
 */
export function storedIn(
  meshes: readonly Entry[],
  namesOf: (mesh: Entry) => readonly string[],
): Entry[] {
  return meshes.flatMap((mesh) => {
    const { extras } = mesh;
    const own = isEntry(extras) ? extras['elastomorph'] : undefined;
    if (!isEntry(extras) || !isEntry(own)) return [];
    return [Number(own['version']) > 2 ? apart(own, extras['targetNames'], namesOf(mesh)) : own];
  });
}

function apart(own: Entry, given: unknown, names: readonly string[]): Entry {
  if (!Array.isArray(given) || !Array.isArray(own['morphs'])) return own;
  const named = (entry: unknown): unknown => {
    const { target, index } = isEntry(entry) ? entry : {};
    const told = typeof index === 'number' && given[index] === target;
    return told ? { ...(entry as Entry), target: names[index] } : entry;
  };
  const morphs = own['morphs'].map((morph: unknown) =>
    isEntry(morph) && Array.isArray(morph['bends'])
      ? named({ ...morph, bends: morph['bends'].map(named) })
      : named(morph),
  );
  return { ...own, morphs };
}
