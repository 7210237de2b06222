// A file whose meshes are compressed as one whose are not: every reader then finds plain bytes.
import type { GltfContent } from '../container';
import { GltfDocument, isEntry, type Entry } from '../document';
import { dracoMeshes, type StandIn } from './draco';
import { meshoptViews } from './meshopt';
import { unpack } from './unpack';

/**
 * The same content with its compressed views and primitives unpacked, each into a buffer of its own.
 *
 * @throws Error with a sentence that names the file and what to do
 */
export async function unpackedContent(content: GltfContent): Promise<GltfContent> {
  const file: GltfDocument = new GltfDocument(content);
  const views = meshoptViews(file);
  const meshes = dracoMeshes(file);
  if (views.length === 0 && meshes.length === 0) return content;
  const job = { views: views.map(({ packed }) => packed), meshes: meshes.map((m) => m.packed) };
  const answer = await unpack(job);
  if ('problem' in answer) file.refuse(`${answer.problem}. Export it again, or uncompressed.`);
  const made = new Rewritten(content);
  views.forEach(({ number }, i) => made.view(number, answer.views[i]!));
  meshes.forEach(({ standIns }, i) =>
    standIns.forEach((standIn, k) => made.accessor(standIn, answer.meshes[i]![k]!)),
  );
  return made.content();
}

/** A document whose views and accessors change; the one it comes from stays as it is. */
class Rewritten {
  private readonly buffers: Uint8Array[];
  private readonly views: Entry[];
  private readonly accessors: Entry[];

  constructor(private readonly from: GltfContent) {
    const listed = (key: string) => [...((from.document[key] ?? []) as Entry[])];
    this.buffers = [...from.buffers];
    [this.views, this.accessors] = [listed('bufferViews'), listed('accessors')];
  }

  view(number: number, bytes: Uint8Array): void {
    const { byteStride } = this.views[number]!;
    const stride = byteStride === undefined ? {} : { byteStride };
    this.views[number] = { buffer: this.held(bytes), byteLength: bytes.length, ...stride };
  }

  accessor({ number, corners }: StandIn, bytes: Uint8Array): void {
    const before = this.accessors[number];
    const bufferView = this.views.push({ buffer: this.held(bytes), byteLength: bytes.length }) - 1;
    const type = corners ? { componentType: 5125 } : {};
    this.accessors[number] = { ...(isEntry(before) ? before : {}), ...type, bufferView, byteOffset: 0 };
  }

  content(): GltfContent {
    const { document, ...rest } = this.from;
    const { buffers, views: bufferViews, accessors } = this;
    return { ...rest, buffers, document: { ...document, bufferViews, accessors } };
  }

  private held(bytes: Uint8Array): number {
    return this.buffers.push(bytes) - 1;
  }
}
