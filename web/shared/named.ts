// What stands by names that people give, which may be those that every plain object has: `constructor`.

/** What is under a name. */
export function ownOf<T>(things: Readonly<Record<string, T>>, name: string): T | undefined {
  return Object.hasOwn(things, name) ? things[name] : undefined;
}

/** The number of a name, 0 where it has none. */
export function numberOf(numbers: Readonly<Record<string, number>>, name: string): number {
  return ownOf(numbers, name) ?? 0;
}

/** Numbers to be filled in, without a prototype: `__proto__` is a name there as any other. */
export function numbersByName(
  from: Readonly<Record<string, number>> = {},
): Record<string, number> {
  return Object.assign(Object.create(null) as Record<string, number>, from);
}
