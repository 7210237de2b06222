// Views packed by meshoptimizer: EXT_meshopt_compression and KHR_meshopt_compression.
import { grouped } from '../container';
import { isEntry, shown, type Entry, type GltfDocument } from '../document';
import type { PackedView } from './jobs';

const EXTENSIONS = ['EXT_meshopt_compression', 'KHR_meshopt_compression'];
const LARGEST_ROW = 256;
/** Bytes that a row may have under each filter; none named: any. */
const FILTERS: Readonly<Record<string, readonly number[]>> = {
  NONE: [],
  OCTAHEDRAL: [4, 8],
  QUATERNION: [8],
  EXPONENTIAL: [],
  COLOR: [4, 8],
};

/** The packed views of a file, by their numbers; what is said of them is checked. */
export function meshoptViews(file: GltfDocument): { number: number; packed: PackedView }[] {
  return file.items('bufferViews').flatMap((view, number) => {
    const extensions = isEntry(view) ? view['extensions'] : undefined;
    if (!isEntry(extensions)) return [];
    const name = EXTENSIONS.find((known) => known in extensions);
    if (name === undefined) return [];
    const of = `buffer view ${number}, packed by meshoptimizer,`;
    const said = extensions[name];
    if (!isEntry(said)) file.damaged(`${of} does not say how`);
    return [{ number, packed: packedView(file, view as Entry, said, of) }];
  });
}

function packedView(file: GltfDocument, view: Entry, said: Entry, of: string): PackedView {
  const { mode, filter = 'NONE' } = said;
  const [count, stride] = [file.whole(said, 'count', of), file.whole(said, 'byteStride', of)];
  const problem = problemWith(count, stride, mode, filter);
  if (problem) file.damaged(`${of} ${problem}`);
  if (file.whole(view, 'byteLength', of) !== count * stride)
    file.damaged(`${of} announces ${grouped(count)} rows that are not its byteLength`);
  file.spend(count * stride);
  const bytes = file.range(said, of);
  return { name: of.replace(/,$/, ''), bytes, count, stride, mode: String(mode), filter: String(filter) };
}

function problemWith(count: number, stride: number, mode: unknown, filter: unknown): string | null {
  const rows = mode === 'ATTRIBUTES';
  if (!rows && mode !== 'TRIANGLES' && mode !== 'INDICES') return `has the mode ${shown(mode)}`;
  const sizes = typeof filter === 'string' ? FILTERS[filter] : undefined;
  if (!sizes || (filter !== 'NONE' && !rows)) return `has the filter ${shown(filter)}`;
  const fits = rows
    ? stride >= 4 && stride <= LARGEST_ROW && stride % 4 === 0
    : stride === 2 || stride === 4;
  if (!fits || (sizes.length > 0 && !sizes.includes(stride))) return `has rows of ${stride} bytes`;
  if (count < 1 || (mode === 'TRIANGLES' && count % 3 !== 0)) return `has ${grouped(count)} rows`;
  return null;
}
