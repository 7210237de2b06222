// What two pages have made of one list: both is kept.

/**
 * The changes of both together. Where both changed one item differently, theirs has the name and
 * mine another.
 *
 * @param base the list that both began with.
 * @param nameOf what items are told apart by.
 * @param renamed an item under a name that those in a list do not have.
 */
export function merged<T>(
  base: readonly T[],
  mine: readonly T[],
  theirs: readonly T[],
  nameOf: (item: T) => string,
  renamed: (item: T, others: readonly T[]) => T,
): readonly T[] {
  if (same(theirs, base) || same(mine, theirs)) return mine;
  if (same(mine, base)) return theirs;
  const [before, own] = [byName(base, nameOf), byName(mine, nameOf)];
  const found = theirs.flatMap((item) => {
    const [was, now] = [before.get(nameOf(item)), own.get(nameOf(item))];
    if (was === undefined || !same(was, item)) return [item]; // theirs is new, or they changed it
    return now === undefined ? [] : [now];
  });
  const present = byName(found, nameOf);
  for (const item of mine) {
    const name = nameOf(item);
    const there = present.get(name);
    const changed = !before.has(name) || !same(before.get(name), item);
    if (!changed || (there !== undefined && same(there, item))) continue;
    const kept = there === undefined ? item : renamed(item, found);
    found.push(kept);
    present.set(nameOf(kept), kept);
  }
  return found;
}

function same(one: unknown, other: unknown): boolean {
  return one === other || JSON.stringify(one) === JSON.stringify(other);
}

function byName<T>(items: readonly T[], nameOf: (item: T) => string): Map<string, T> {
  return new Map(items.map((item) => [nameOf(item), item]));
}
