// The paths that the command makes by other methods, and what is known of each.
import { isEntry, type Entry } from '../files/document';
import { openFile } from '../files/open';
import type { Model, Services } from '../types/model';
import { ask, modelBytes } from './asking';

/** The path of one target, lengths in the unit of the rig. */
export interface Row {
  readonly name: string;
  readonly said: string; // by the settings, of this target by its own name
  readonly laws: readonly string[]; // between its in-betweens, where it has any
  readonly method: string;
  readonly extra: number; // morph targets besides its own
  readonly bytes: number;
  readonly largest: number; // distance from the straight line
  readonly mean: number;
  readonly between: readonly [number, number] | null; // largest and mean, from its in-betweens
}

/** A path that was made to be looked at. */
export interface Tried {
  readonly row: Row;
  readonly model: Model;
  readonly warnings: readonly string[];
}

export interface Listed {
  readonly rows: readonly Row[];
  readonly methods: readonly string[];
}

export interface Saved {
  readonly rows: readonly Row[];
  readonly model: Model;
  readonly file: string;
}

export type Says = (words: string) => void;

export class Bench {
  private readonly tried = new Map<string, Tried>();

  constructor(
    private readonly services: Services,
    private readonly base: Model,
  ) {}

  async list(says: Says): Promise<Listed> {
    const done = await ask(this.services.methods ?? '', '{}', says);
    return { rows: rowsIn(done), methods: textsIn(done['methods']) };
  }

  /** What is known of the path to a target by a method, once it was made. */
  known(target: string, method: string): Row | undefined {
    return this.tried.get(keyOf(target, method))?.row;
  }

  /** The path to a target by a method; made once. */
  async try(target: string, method: string, says: Says, signal: AbortSignal): Promise<Tried> {
    const key = keyOf(target, method);
    const known = this.tried.get(key);
    if (known) return known;
    const question = JSON.stringify({ target, method });
    const done = await ask(this.services.methods ?? '', question, says, signal);
    const bytes = await modelBytes(String(done['glb']), signal);
    const { diameter } = this.base;
    const made = await openFile(method, bytes, { name: method, role: 'method', diameter });
    const model = dressedAs(made, this.base);
    const row = rowsIn({ rows: [done['row']] })[0]!;
    const found = { row, model, warnings: textsIn(done['warnings']) };
    this.tried.set(key, found);
    return found;
  }

  async save(
    choices: Readonly<Record<string, string>>,
    known: Readonly<Record<string, string>>,
    base: Model,
    says: Says,
  ): Promise<Saved> {
    const question = JSON.stringify({ choices, known });
    const done = await ask(this.services.save ?? '', question, says);
    const { name, role, loops, diameter } = base;
    const bytes = await modelBytes(String(done['glb']));
    const model = await openFile(name, bytes, { name, role, loops, diameter });
    // What a choice is measured against may be another path from now on.
    this.tried.clear();
    return { rows: rowsIn(done), model, file: String(done['file']) };
  }
}

const keyOf = (target: string, method: string) => JSON.stringify([target, method]);

/** The shapes of a model, which come without looks, with those of another of the same vertices. */
function dressedAs(model: Model, other: Model): Model {
  if (model.neutral.length !== other.neutral.length) return model;
  const { triangles, parts, uv, colours, fileNormals, head, seams, edges, loops } = other;
  return { ...model, triangles, parts, uv, colours, fileNormals, head, seams, edges, loops };
}

function rowsIn(done: Entry): Row[] {
  const rows = Array.isArray(done['rows']) ? done['rows'].filter(isEntry) : [];
  return rows as unknown as Row[];
}

function textsIn(value: unknown): string[] {
  return Array.isArray(value) ? value.map(String) : [];
}
