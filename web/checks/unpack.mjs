// Decodes every array of a glTF file that is compressed, and leaves all the rest as it is.
//
//   node checks/unpack.mjs IN OUT.gltf
//
// Views of EXT_meshopt_compression and KHR_meshopt_compression, and primitives of
// KHR_draco_mesh_compression, become plain views; every number of every entry stays. Buffers are
// written beside OUT.gltf.
import { readFile, writeFile } from 'node:fs/promises';
import { basename, dirname, join } from 'node:path';
import draco3d from 'draco3dgltf';
import { MeshoptDecoder } from 'meshoptimizer';

const MESHOPT = ['EXT_meshopt_compression', 'KHR_meshopt_compression'];
const DRACO = 'KHR_draco_mesh_compression';
const COMPONENTS = { 5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4 };
const WIDTHS = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 };

async function read(path) {
  const bytes = await readFile(path);
  let json = JSON.parse(bytes.toString('latin1', 0, 4) === 'glTF' ? '{}' : bytes.toString());
  let chunk = null;
  if (bytes.toString('latin1', 0, 4) === 'glTF') {
    const size = bytes.readUInt32LE(12);
    json = JSON.parse(bytes.toString('utf8', 20, 20 + size));
    chunk = bytes.subarray(28 + size);
  }
  const buffers = await Promise.all(
    (json.buffers ?? []).map(async ({ uri, byteLength }, number) => {
      if (!uri) return number === 0 && chunk ? chunk.subarray(0, byteLength) : new Uint8Array(0);
      if (uri.startsWith('data:')) return Buffer.from(uri.slice(uri.indexOf(',') + 1), 'base64');
      return readFile(join(dirname(path), decodeURIComponent(uri)));
    }),
  );
  return { json, buffers };
}

// A growing buffer, and a view of what is appended to it.
function appender(json, number) {
  const parts = [];
  let length = 0;
  const add = (bytes, view) => {
    const padded = Buffer.alloc(Math.ceil(bytes.byteLength / 4) * 4);
    Buffer.from(bytes.buffer, bytes.byteOffset, bytes.byteLength).copy(padded);
    parts.push(padded);
    Object.assign(view, { buffer: number, byteOffset: length, byteLength: bytes.byteLength });
    length += padded.byteLength;
  };
  return { add, all: () => Buffer.concat(parts) };
}

function unpackViews({ json, buffers }, add) {
  for (const view of json.bufferViews ?? []) {
    const name = MESHOPT.find((own) => view.extensions?.[own]);
    if (!name) continue;
    const { buffer, byteOffset = 0, byteLength, byteStride, count, mode, filter } =
      view.extensions[name];
    const source = new Uint8Array(buffers[buffer].subarray(byteOffset, byteOffset + byteLength));
    const found = new Uint8Array(count * byteStride);
    MeshoptDecoder.decodeGltfBuffer(found, count, byteStride, source, mode, filter);
    delete view.extensions;
    add(found, view);
  }
}

function unpackPrimitives({ json, buffers }, add, draco) {
  for (const mesh of json.meshes ?? []) {
    for (const primitive of mesh.primitives) {
      const packed = primitive.extensions?.[DRACO];
      if (!packed) continue;
      const view = json.bufferViews[packed.bufferView];
      const start = view.byteOffset ?? 0;
      const source = buffers[view.buffer].subarray(start, start + view.byteLength);
      const decoder = new draco.Decoder();
      const geometry = new draco.Mesh();
      const status = decoder.DecodeArrayToMesh(new Int8Array(source), source.length, geometry);
      if (!status.ok()) throw new Error(`Draco: ${status.error_msg()}`);
      const place = (number, bytes) => {
        json.bufferViews.push({});
        add(bytes, json.bufferViews.at(-1));
        json.accessors[number].bufferView = json.bufferViews.length - 1;
        delete json.accessors[number].byteOffset;
      };
      for (const [name, id] of Object.entries(packed.attributes)) {
        const number = primitive.attributes[name];
        place(number, attribute(draco, decoder, geometry, id, json.accessors[number]));
      }
      place(primitive.indices, triangles(draco, decoder, geometry, json.accessors[primitive.indices]));
      delete primitive.extensions;
    }
  }
}

function attribute(draco, decoder, geometry, id, { componentType, count, type }) {
  const kinds = {
    5120: draco.DT_INT8,
    5121: draco.DT_UINT8,
    5122: draco.DT_INT16,
    5123: draco.DT_UINT16,
    5125: draco.DT_UINT32,
    5126: draco.DT_FLOAT32,
  };
  const size = count * WIDTHS[type] * COMPONENTS[componentType];
  const at = draco._malloc(size);
  const own = decoder.GetAttributeByUniqueId(geometry, id);
  decoder.GetAttributeDataArrayForAllPoints(geometry, own, kinds[componentType], size, at);
  const found = new Uint8Array(draco.HEAPU8.buffer, at, size).slice();
  draco._free(at);
  return found;
}

function triangles(draco, decoder, geometry, { componentType, count }) {
  const at = draco._malloc(4 * count);
  decoder.GetTrianglesUInt32Array(geometry, 4 * count, at);
  const found = new Uint32Array(draco.HEAPU8.buffer, at, count).slice();
  draco._free(at);
  const kinds = { 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array };
  return kinds[componentType].from(found);
}

const [source, out] = process.argv.slice(2);
if (!out?.endsWith('.gltf')) {
  console.error('usage: node checks/unpack.mjs IN OUT.gltf');
  process.exit(2);
}
await MeshoptDecoder.ready;
const file = await read(source);
const { json, buffers } = file;
const { add, all } = appender(json, buffers.length);
unpackViews(file, add);
unpackPrimitives(file, add, await draco3d.createDecoderModule());
buffers.push(all());
json.buffers = [...(json.buffers ?? []), {}];
for (const key of ['extensionsUsed', 'extensionsRequired']) {
  json[key] = (json[key] ?? []).filter((name) => ![...MESHOPT, DRACO].includes(name));
}
await Promise.all(
  buffers.map((content, number) => {
    const uri = `${basename(out)}-${number}.bin`;
    Object.assign(json.buffers[number], { uri, byteLength: content.byteLength });
    delete json.buffers[number].extensions;
    return writeFile(join(dirname(out), uri), content);
  }),
);
await writeFile(out, JSON.stringify(json));
