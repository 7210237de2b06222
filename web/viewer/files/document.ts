// The JSON document of a file, whose numbers and lists are checked as they are asked for.
import { grouped, refuse, type GltfContent } from './container';

// What may be missing and still leave the face as it is, or is read here.
const HARMLESS =
  /^(KHR_(mesh_quantization|draco_mesh_compression|meshopt_compression|node_visibility)$|EXT_meshopt_compression$|KHR_(materials|texture|lights|animation|audio|physics|interactivity|xmp)|EXT_(materials|texture|lights)_|FB_ngon_encoding$|MSFT_|VRM)/;

export type Entry = Readonly<Record<string, unknown>>;

/** A document that refuses what it is asked for and does not have. */
export class GltfDocument {
  readonly name: string;
  readonly buffers: readonly Uint8Array[];
  readonly size: number;
  private readonly root: Entry;
  private spent = 0;

  constructor({ name, document, buffers, size }: GltfContent) {
    [this.name, this.root, this.buffers, this.size] = [name, document, buffers, size];
    this.requireExtensions();
  }

  refuse(problem: string): never {
    refuse(this.name, problem);
  }

  damaged(what: string): never {
    this.refuse(`${what}: the file is damaged. Export it again.`);
  }

  /** A list of the document; empty where it is left out. */
  items(key: string): readonly unknown[] {
    return this.list(this.root, key);
  }

  /** An entry of a list of the document, by the number that the file gives. */
  item(key: string, number: unknown, of: string): Entry {
    const items = this.items(key);
    const entry = typeof number === 'number' ? items[number] : undefined;
    if (!isEntry(entry))
      this.damaged(`${of} names number ${shown(number)} of ${items.length} ${key}`);
    return entry;
  }

  value(key: string): unknown {
    return this.root[key];
  }

  list(holder: Entry, key: string): readonly unknown[] {
    const found = holder[key] ?? [];
    if (!Array.isArray(found)) this.damaged(`'${key}' is no list`);
    return found;
  }

  whole(holder: Entry, key: string, of: string, otherwise?: number): number {
    const found = holder[key] ?? otherwise;
    if (typeof found !== 'number' || !Number.isSafeInteger(found) || found < 0) {
      this.damaged(`'${key}' of ${of} is ${shown(found)} where a whole number was expected`);
    }
    return found;
  }

  numbers(
    holder: Entry,
    key: string,
    count: number,
    otherwise: readonly number[],
  ): readonly number[] {
    const found = holder[key];
    if (found === undefined) return otherwise;
    const right = Array.isArray(found) && found.length === count && found.every(Number.isFinite);
    if (!right) this.damaged(`'${key}' is not ${count} numbers`);
    return found as number[];
  }

  /** The bytes of a buffer that an entry (a view, or what says how it is packed) refers to. */
  range(entry: Entry, of: string): Uint8Array {
    const start = this.whole(entry, 'byteOffset', of, 0);
    const length = this.whole(entry, 'byteLength', of);
    const buffer =
      this.buffers[this.whole(entry, 'buffer', of)] ??
      this.damaged(`${of} names a buffer that does not exist`);
    if (start + length > buffer.length) this.damaged(`${of} reaches beyond its buffer`);
    return buffer.subarray(start, start + length);
  }

  /**
   * Counts memory about to be used. Sparse targets are far smaller in a file than in memory, but
   * not arbitrarily so: a damaged count must not stop the browser.
   */
  spend(bytes: number): void {
    this.spent += bytes;
    if (this.spent > 2 ** 28 + 200 * this.size || this.spent > 2 ** 32) {
      this.refuse(
        `it asks for ${grouped(Math.round(this.spent / 2 ** 20))} MiB of memory, far more than ` +
          `its ${(this.size / 2 ** 20).toFixed(1)} MiB can hold: it is damaged. Export it again.`,
      );
    }
  }

  private requireExtensions(): void {
    for (const name of this.items('extensionsRequired')) {
      const text = shown(name).replaceAll('"', '');
      if (!HARMLESS.test(text)) {
        this.refuse(`it cannot be read without the extension ${text}. Export it again without it.`);
      }
    }
  }
}

export function isEntry(value: unknown): value is Entry {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
}

/** A value of the file, short enough for a message. */
export function shown(value: unknown): string {
  const text = JSON.stringify(value) ?? 'missing';
  return text.length > 60 ? `${text.slice(0, 60)}…` : text;
}

/** An entry of a list of the document, empty where there is none of that number. */
export function listed(file: GltfDocument, key: string, number: unknown): Entry {
  const found = typeof number === 'number' ? file.items(key)[number] : undefined;
  return isEntry(found) ? found : {};
}

/** An object within another, empty where there is none. */
export function objectIn(holder: Entry, key: string): Entry {
  const found = holder[key];
  return isEntry(found) ? found : {};
}

/** A number of an object, where it has one. */
export function numberIn(holder: Entry, key: string, otherwise: number): number {
  const found = holder[key];
  return typeof found === 'number' && Number.isFinite(found) ? found : otherwise;
}

/** As many numbers as there are otherwise, where these are there. */
export function numbersIn(
  holder: Entry,
  key: string,
  otherwise: readonly number[],
): readonly number[] {
  const found = holder[key];
  const right =
    Array.isArray(found) && found.length === otherwise.length && found.every(Number.isFinite);
  return right ? (found as number[]) : otherwise;
}
