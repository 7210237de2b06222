// Unpacks, in a worker: a decoder that a damaged stream stops or keeps busy can be ended there.
import { MeshoptDecoder } from 'meshoptimizer/decoder';
import load, { type Draco } from 'three/addons/libs/draco/gltf/draco_wasm_wrapper.js';
import type { Answer, Job, PackedAttribute, PackedMesh, PackedView } from './jobs';

addEventListener('message', ({ data }: MessageEvent<Job>) => {
  done(data).then(postMessage, (error: Error) =>
    postMessage({ problem: error.message } satisfies Answer),
  );
});

async function done({ views, meshes, draco }: Job): Promise<Answer> {
  await MeshoptDecoder.ready;
  const library = draco && (await load({ wasmBinary: draco }));
  return {
    views: views.map(unpackedView),
    meshes: library ? meshes.map((mesh) => unpackedMesh(library, mesh)) : [],
  };
}

function unpackedView({ name, bytes, count, stride, mode, filter }: PackedView): Uint8Array {
  const rows = new Uint8Array(count * stride);
  try {
    MeshoptDecoder.decodeGltfBuffer(rows, count, stride, bytes, mode, filter);
  } catch {
    throw new Error(`the stream of ${name} is damaged`);
  }
  return rows;
}

function unpackedMesh(draco: Draco, { name, bytes, attributes }: PackedMesh): Uint8Array[] {
  const decoder = new draco.Decoder();
  const mesh = new draco.Mesh();
  let whole = false;
  try {
    whole = decoder.DecodeArrayToMesh(bytes, bytes.length, mesh).ok() && mesh.ptr !== 0;
  } catch {
    // It has run out of memory, or into a trap: what it says of that helps nobody.
  }
  if (!whole) throw new Error(`the stream of ${name} is damaged`);
  const kinds: Readonly<Record<number, readonly [number, number]>> = {
    5120: [draco.DT_INT8, 1],
    5121: [draco.DT_UINT8, 1],
    5122: [draco.DT_INT16, 2],
    5123: [draco.DT_UINT16, 2],
    5125: [draco.DT_UINT32, 4],
    5126: [draco.DT_FLOAT32, 4],
  };
  const unpacked = ({ id, componentType, width, count }: PackedAttribute) => {
    const corners = id < 0;
    const [kind, bytesEach] = kinds[componentType]!;
    const attribute = corners ? null : decoder.GetAttributeByUniqueId(mesh, id);
    const found = corners ? 3 * mesh.num_faces() : mesh.num_points();
    if (attribute && (!attribute.ptr || attribute.num_components() !== width))
      throw new Error(`${name} has no attribute ${id} of ${width} numbers`);
    if (found !== count)
      throw new Error(
        `${name} holds ${found} ${corners ? 'corners' : 'vertices'}, its accessor announces ${count}`,
      );
    const size = count * width * (corners ? 4 : bytesEach);
    const at = draco._malloc(size);
    if (attribute) decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, kind, size, at);
    else decoder.GetTrianglesUInt32Array(mesh, size, at);
    return draco.HEAPU8.slice(at, at + size);
  };
  return attributes.map(unpacked);
}
