// Opens the container of a file: the JSON document and its bytes, or a sentence on what it is.
import { bytesOfBase64 } from '../../shared/base64';

export interface GltfContent {
  readonly name: string; // of the file, for messages
  readonly document: Readonly<Record<string, unknown>>;
  readonly buffers: readonly Uint8Array[];
  readonly size: number; // bytes of the file
}

const JSON_CHUNK = 0x4e4f534a;
const BINARY_CHUNK = 0x004e4942;
const TO_GLB =
  'Turn it into a GLB with "elastomorph export FILE -o face.glb", ' +
  'or export it as glTF Binary (.glb).';

/** A whole number as people read it. */
export function grouped(count: number): string {
  return count.toLocaleString('en');
}

/** Refuses a file with a sentence for the person who opened it. */
export function refuse(name: string, problem: string): never {
  throw new Error(`${name}: ${problem}`);
}

/** The document and the buffers of a GLB, or of a .gltf that holds its bytes itself. */
export async function openContainer(name: string, bytes: ArrayBuffer): Promise<GltfContent> {
  if (bytes.byteLength === 0) refuse(name, 'the file is empty. Export it again.');
  const start = String.fromCharCode(...new Uint8Array(bytes, 0, Math.min(bytes.byteLength, 4096)));
  const binary = start.startsWith('glTF');
  if (!binary && !/^\s*(\u00ef\u00bb\u00bf)?\s*\{/.test(start))
    refuse(name, `this is ${kindOf(start)}, not a GLB. ${TO_GLB}`);
  const { text, blob } = binary ? chunks(name, bytes) : { text: bytes, blob: null };
  const document = parsed(name, text);
  const { version } = (document['asset'] ?? {}) as { version?: unknown };
  if (typeof version !== 'string') {
    refuse(name, `this is JSON, but no glTF: it has no asset version. Open a .glb.`);
  }
  if (!version.startsWith('2.')) {
    refuse(
      name,
      `it is glTF ${version.slice(0, 8)}; expected glTF 2.0. Export it again as glTF 2.0.`,
    );
  }
  return { name, document, buffers: await buffersOf(name, document, blob), size: bytes.byteLength };
}

function chunks(name: string, bytes: ArrayBuffer): { text: ArrayBuffer; blob: Uint8Array | null } {
  const view = new DataView(bytes);
  if (bytes.byteLength < 20)
    refuse(name, 'this GLB is cut off before its first chunk. Copy or export it again.');
  const version = view.getUint32(4, true);
  if (version !== 2)
    refuse(
      name,
      `it is a GLB of version ${version}; expected version 2. Export it again as glTF 2.0.`,
    );
  const length = view.getUint32(8, true);
  if (length > bytes.byteLength) {
    refuse(
      name,
      `this GLB announces ${grouped(length)} bytes but has ` +
        `${grouped(bytes.byteLength)}: it is cut off. Copy or export it again.`,
    );
  }
  let text: ArrayBuffer | null = null;
  let blob: Uint8Array | null = null;
  for (let place = 12; place + 8 <= length;) {
    const size = view.getUint32(place, true);
    const kind = view.getUint32(place + 4, true);
    if (place + 8 + size > length)
      refuse(
        name,
        `the chunk at byte ${place} is longer than the file: it is damaged. Export it again.`,
      );
    if (kind === JSON_CHUNK) text ??= bytes.slice(place + 8, place + 8 + size);
    if (kind === BINARY_CHUNK) blob ??= new Uint8Array(bytes, place + 8, size);
    place += 8 + size;
  }
  if (!text) refuse(name, 'this GLB has no JSON document: it is damaged. Export it again.');
  return { text, blob };
}

function parsed(name: string, text: ArrayBuffer): Readonly<Record<string, unknown>> {
  try {
    const found: unknown = JSON.parse(new TextDecoder('utf-8', { fatal: true }).decode(text));
    if (found && typeof found === 'object' && !Array.isArray(found))
      return found as Record<string, unknown>;
  } catch {
    // What the parser says ("unexpected token") helps nobody who did not write the file.
  }
  refuse(name, 'its JSON document is damaged and cannot be read. Copy or export it again.');
}

async function buffersOf(
  name: string,
  document: Readonly<Record<string, unknown>>,
  blob: Uint8Array | null,
): Promise<Uint8Array[]> {
  const entries: unknown = document['buffers'] ?? [];
  if (!Array.isArray(entries))
    refuse(name, `its 'buffers' are no list: it is damaged. Export it again.`);
  return Promise.all(
    entries.map((entry: { uri?: unknown; byteLength?: unknown }, number) =>
      buffer(name, entry ?? {}, number, blob),
    ),
  );
}

async function buffer(
  name: string,
  { uri, byteLength }: { uri?: unknown; byteLength?: unknown },
  number: number,
  blob: Uint8Array | null,
): Promise<Uint8Array> {
  let found: Uint8Array = new Uint8Array(0);
  // What is unpacked may be announced as a buffer of its own, which is not there.
  if (uri === undefined && number > 0) return found;
  if (uri === undefined) found = blob ?? found;
  else if (typeof uri === 'string' && /^data:[^,]*;base64,/.test(uri)) {
    found = await bytesOfBase64(uri.slice(uri.indexOf(',') + 1)).catch(() =>
      refuse(name, `the bytes of buffer ${number} are damaged. Export it again.`),
    );
  } else {
    const beside = typeof uri === 'string' ? ` ("${uri.slice(0, 60)}")` : '';
    refuse(
      name,
      `it keeps its bytes in another file${beside}, which this page cannot open. Export it as ` +
        'glTF Binary (.glb), with everything inside.',
    );
  }
  const length = typeof byteLength === 'number' ? byteLength : -1;
  if (length < 0 || length > found.length) {
    refuse(
      name,
      `buffer ${number} announces ${grouped(length)} bytes, but there are ` +
        `${grouped(found.length)}: it is cut off. Copy or export it again.`,
    );
  }
  return found;
}

const KINDS: readonly (readonly [RegExp, string])[] = [
  [/^Kaydara FBX|^; FBX/, 'an FBX file'],
  [/^PXR-USDC|^#usda/, 'a USD file'],
  [/^ply\r?\n/, 'a PLY file'],
  [/^solid /, 'an STL file'],
  [/^BLENDER/, 'a Blender file'],
  [/^PK\x03\x04/, 'a ZIP archive (or a USDZ or NPZ file)'],
  [/^\x1f\x8b|^7z|^Rar!/, 'a compressed archive'],
  [/^\x93NUMPY/, 'a NumPy file'],
  [/^\x89PNG|^\xff\xd8\xff|^GIF8|^RIFF....WEBP/s, 'a picture'],
  [/^\/\/Maya|^FOR4/, 'a Maya scene'],
  [/^\s*<(!doctype )?html/i, 'an HTML page (perhaps a download that asked you to sign in)'],
  [/^\s*<\?xml|^\s*<COLLADA/, 'an XML file'],
  [/^version https:\/\/git-lfs/, 'the pointer of Git LFS to a file, not the file itself'],
  [/(^|\n)\s*(v|vn|vt|f|mtllib) [^\n]*\n/, 'an OBJ file'],
];

function kindOf(start: string): string {
  return KINDS.find(([pattern]) => pattern.test(start))?.[1] ?? 'a file of an unknown kind';
}
