// Accessors as arrays of numbers: dense, sparse or quantised, checked against the bytes there are.
import { grouped } from './container';
import { shown, type Entry, type GltfDocument } from './document';

type Numbers = Float32Array | Uint32Array | Uint16Array | Int16Array | Uint8Array | Int8Array;
type Kind = {
  new (buffer: ArrayBuffer, offset: number, length: number): Numbers;
  readonly BYTES_PER_ELEMENT: number;
  readonly name: string;
};

/** Arrays by the numbers that glTF gives to the types of components. */
export const KINDS: Readonly<Record<number, Kind>> = {
  5120: Int8Array,
  5121: Uint8Array,
  5122: Int16Array,
  5123: Uint16Array,
  5125: Uint32Array,
  5126: Float32Array,
} as unknown as Readonly<Record<number, Kind>>;
export const WIDTHS: Readonly<Record<string, number>> = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 };

/** How many elements an accessor has. */
export function countOf(file: GltfDocument, number: unknown, of: string): number {
  return file.whole(file.item('accessors', number, of), 'count', `accessor ${shown(number)}`);
}

/** The numbers of an accessor as floats, `width` for each element; new memory, the caller's. */
export function floats(
  file: GltfDocument,
  number: unknown,
  width: number,
  of: string,
  count?: number,
): Float32Array {
  const length = count ?? countOf(file, number, of);
  file.spend(4 * width * length);
  const found = new Float32Array(width * length);
  floatsInto(file, number, width, of, found);
  return found;
}

/** Writes the numbers of an accessor over `out`: `width` for each element it must have. */
export function floatsInto(
  file: GltfDocument,
  number: unknown,
  width: number,
  of: string,
  out: Float32Array,
): void {
  const accessor = file.item('accessors', number, of);
  const name = `accessor ${shown(number)}`;
  const count = file.whole(accessor, 'count', name);
  if (count * width !== out.length) {
    file.damaged(
      `${name} of ${of} has ${grouped(count)} elements, expected ${grouped(out.length / width)}`,
    );
  }
  const kind = kindOf(file, accessor, width, name, of);
  const scale = accessor['normalized'] === true ? normaliser(kind) : null;
  if (accessor['bufferView'] !== undefined) {
    const offset = file.whole(accessor, 'byteOffset', name, 0);
    const values = elements(file, accessor['bufferView'], offset, count, width, kind, name);
    out.set(values);
    if (scale) for (let i = 0; i < out.length; i += 1) out[i] = scale(out[i]!);
  }
  if (accessor['sparse'] !== undefined)
    sparseInto(file, accessor['sparse'] as Entry, width, kind, scale, name, out);
}

/** Vertex indices of triangles. */
export function indices(file: GltfDocument, number: unknown, of: string): Uint32Array {
  const accessor = file.item('accessors', number, of);
  const name = `accessor ${shown(number)}`;
  const kind = kindOf(file, accessor, 1, name, of);
  if (!kind.name.startsWith('Uint')) file.damaged(`${name} holds no vertex numbers`);
  const count = file.whole(accessor, 'count', name);
  if (accessor['bufferView'] === undefined) file.damaged(`${name} has no bytes`);
  file.spend(4 * count);
  return Uint32Array.from(
    elements(
      file,
      accessor['bufferView'],
      file.whole(accessor, 'byteOffset', name, 0),
      count,
      1,
      kind,
      name,
    ),
  );
}

function sparseInto(
  file: GltfDocument,
  sparse: Entry,
  width: number,
  kind: Kind,
  scale: ((value: number) => number) | null,
  name: string,
  out: Float32Array,
): void {
  const of = `the sparse values of ${name}`;
  const count = file.whole(sparse, 'count', of);
  if (count * width > out.length) file.damaged(`${of} are more than its elements`);
  const places = sparse['indices'] as Entry;
  const content = sparse['values'] as Entry;
  if (!places || !content) file.damaged(`${of} are incomplete`);
  const placeKind =
    KINDS[Number(places['componentType'])] ?? file.damaged(`${of} have places of no type`);
  const at = elements(
    file,
    places['bufferView'],
    file.whole(places, 'byteOffset', of, 0),
    count,
    1,
    placeKind,
    of,
  );
  const values = elements(
    file,
    content['bufferView'],
    file.whole(content, 'byteOffset', of, 0),
    count,
    width,
    kind,
    of,
  );
  for (let i = 0; i < count; i += 1) {
    const place = width * at[i]!;
    if (place >= out.length || place < 0) file.damaged(`${of} are out of range`);
    for (let c = 0; c < width; c += 1) {
      const value = values[width * i + c]!;
      out[place + c] = scale ? scale(value) : value;
    }
  }
}

/** The elements of a buffer view: a look at the bytes of the file where they lie close together. */
function elements(
  file: GltfDocument,
  view: unknown,
  offset: number,
  count: number,
  width: number,
  kind: Kind,
  name: string,
): Numbers {
  const entry = file.item('bufferViews', view, name);
  const of = `buffer view ${shown(view)}`;
  const range = file.range(entry, of);
  const size = width * kind.BYTES_PER_ELEMENT;
  const step = file.whole(entry, 'byteStride', of, size) || size;
  if (count > 0 && (step < size || offset + (count - 1) * step + size > range.length)) {
    file.damaged(
      `${name} has ${grouped(count)} elements, which do not fit into the ` +
        `${grouped(range.length)} bytes of ${of}`,
    );
  }
  const first = range.byteOffset + offset;
  const bytes = range.buffer as ArrayBuffer;
  if (step === size && first % kind.BYTES_PER_ELEMENT === 0)
    return new kind(bytes, first, count * width);
  const close = new Uint8Array(count * size);
  for (let i = 0; i < count; i += 1)
    close.set(new Uint8Array(bytes, first + i * step, size), i * size);
  return new kind(close.buffer, 0, count * width);
}

function kindOf(
  file: GltfDocument,
  accessor: Entry,
  width: number,
  name: string,
  of: string,
): Kind {
  const kind = KINDS[Number(accessor['componentType'])];
  if (!kind || WIDTHS[String(accessor['type'])] !== width)
    file.damaged(`${name} of ${of} has a type that ${of} cannot have`);
  return kind;
}

function normaliser(kind: Kind): (value: number) => number {
  const bits = 8 * kind.BYTES_PER_ELEMENT;
  const signed = kind.name.startsWith('Int');
  const most = 2 ** (signed ? bits - 1 : bits) - 1;
  return (value) => Math.max(value / most, -1);
}
