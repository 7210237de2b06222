// Primitives packed with Draco, KHR_draco_mesh_compression: accessors without bytes stand for what
// is in a stream. Morph targets are no part of it; they are plain, in the order of its vertices.
import { KINDS, WIDTHS } from '../accessors';
import { isEntry, shown, type Entry, type GltfDocument } from '../document';
import type { PackedAttribute, PackedMesh } from './jobs';

const EXTENSION = 'KHR_draco_mesh_compression';

/** An accessor that gets its bytes from a stream. */
export interface StandIn {
  readonly number: number;
  readonly corners: boolean; // of triangles
}

export interface DracoMesh {
  readonly packed: PackedMesh;
  /** What each attribute of the stream is for. */
  readonly standIns: readonly StandIn[];
}

/** The packed meshes of a file, each accessor in the first that has it. */
export function dracoMeshes(file: GltfDocument): DracoMesh[] {
  const found: DracoMesh[] = [];
  const known = new Set<number>();
  for (const mesh of file.items('meshes')) {
    for (const primitive of isEntry(mesh) ? file.list(mesh, 'primitives') : []) {
      const extensions = isEntry(primitive) ? primitive['extensions'] : undefined;
      const said = isEntry(extensions) ? extensions[EXTENSION] : undefined;
      if (isEntry(said)) found.push(...packedMesh(file, primitive as Entry, said, known));
    }
  }
  return found;
}

function packedMesh(
  file: GltfDocument,
  primitive: Entry,
  said: Entry,
  known: Set<number>,
): DracoMesh[] {
  const number = said['bufferView'];
  const of = `buffer view ${shown(number)}, packed with Draco,`;
  const [ids, accessors] = [said['attributes'], primitive['attributes']];
  if (!isEntry(ids) || !isEntry(accessors) || typeof primitive['indices'] !== 'number')
    file.damaged(`${of} does not say what it holds`);
  const named = Object.keys(ids).map((key) => [accessors[key], file.whole(ids, key, of)] as const);
  const standIns: StandIn[] = [];
  const attributes: PackedAttribute[] = [];
  for (const [accessor, id] of [...named, [primitive['indices'], -1] as const]) {
    if (typeof accessor !== 'number' || known.has(accessor)) continue;
    const entry = file.item('accessors', accessor, of);
    if (entry['bufferView'] !== undefined) continue; // a plain copy is there too
    known.add(accessor);
    standIns.push({ number: accessor, corners: id < 0 });
    attributes.push(attributeOf(file, entry, id, of));
  }
  if (attributes.length === 0) return [];
  const bytes = file.range(file.item('bufferViews', number, of), of);
  return [{ packed: { name: of.replace(/,$/, ''), bytes, attributes }, standIns }];
}

function attributeOf(file: GltfDocument, entry: Entry, id: number, of: string): PackedAttribute {
  const componentType = Number(entry['componentType']);
  const width = WIDTHS[String(entry['type'])];
  const kind = KINDS[componentType];
  if (!kind || !width) file.damaged(`an accessor of ${of} has no type`);
  const count = file.whole(entry, 'count', of);
  file.spend(count * width * (id < 0 ? 4 : kind.BYTES_PER_ELEMENT));
  return { id, componentType, width, count };
}
