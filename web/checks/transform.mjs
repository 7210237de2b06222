// Puts a glTF file through glTF-Transform, as people do before a character goes on the web.
//
//   node checks/transform.mjs IN OUT STEP…
//
// Steps, in the order given: copy (none), dedup, prune, weld, unweld, join, reorder, quantize,
// dequantize, meshopt, draco, resample, sparse, flatten, palette, center, instance, metalrough,
// simplify, unlit, optimize (a chain of most of them), unpartition, and plain (no compression and no
// quantization of its own: arrays that anyone can read).
// Prints the extensions of what was written as JSON.
import { NodeIO } from '@gltf-transform/core';
import {
  ALL_EXTENSIONS,
  KHRDracoMeshCompression,
} from '@gltf-transform/extensions';
import {
  center,
  dedup,
  dequantize,
  flatten,
  instance,
  join,
  meshopt,
  metalRough,
  palette,
  prune,
  quantize,
  reorder,
  resample,
  simplify,
  sparse,
  unlit,
  unpartition,
  unweld,
  weld,
} from '@gltf-transform/functions';
import draco3d from 'draco3dgltf';
import { MeshoptDecoder, MeshoptEncoder, MeshoptSimplifier } from 'meshoptimizer';

const STEPS = {
  copy: () => [],
  center: () => [center({ pivot: 'below' })],
  instance: () => [instance()],
  metalrough: () => [metalRough()],
  simplify: () => [weld(), simplify({ simplifier: MeshoptSimplifier, ratio: 0.8, error: 0.001 })],
  unlit: () => [unlit()],
  unweld: () => [unweld()],
  dedup: () => [dedup()],
  prune: () => [prune({ keepAttributes: true, keepLeaves: true })],
  weld: () => [weld()],
  join: () => [join()],
  flatten: () => [flatten()],
  palette: () => [palette()],
  reorder: () => [reorder({ encoder: MeshoptEncoder })],
  quantize: () => [quantize()],
  dequantize: () => [dequantize()],
  resample: () => [resample()],
  sparse: () => [sparse()],
  meshopt: () => [meshopt({ encoder: MeshoptEncoder, level: 'medium' })],
  draco: () => [
    (document) =>
      document
        .createExtension(KHRDracoMeshCompression)
        .setRequired(true)
        .setEncoderOptions({ method: KHRDracoMeshCompression.EncoderMethod.EDGEBREAKER }),
  ],
  unpartition: () => [unpartition()],
  plain: () => [
    (document) => {
      const packed = ['EXT_meshopt_compression', 'KHR_meshopt_compression'];
      for (const extension of document.getRoot().listExtensionsUsed()) {
        if ([...packed, 'KHR_draco_mesh_compression'].includes(extension.extensionName)) {
          extension.dispose();
        }
      }
    },
  ],
  optimize: () => [
    dedup(),
    flatten(),
    join(),
    weld(),
    resample(),
    prune({ keepAttributes: false, keepLeaves: false }),
    sparse(),
    meshopt({ encoder: MeshoptEncoder, level: 'high' }),
  ],
};

const [source, out, ...names] = process.argv.slice(2);
if (names.length === 0 || !names.every((name) => name in STEPS)) {
  console.error(`usage: node checks/transform.mjs IN OUT STEP…  (${Object.keys(STEPS).join(' ')})`);
  process.exit(2);
}
await MeshoptDecoder.ready;
await MeshoptEncoder.ready;
await MeshoptSimplifier.ready;
const io = new NodeIO()
  .registerExtensions(ALL_EXTENSIONS)
  .registerDependencies({
    'draco3d.decoder': await draco3d.createDecoderModule(),
    'draco3d.encoder': await draco3d.createEncoderModule(),
    'meshopt.decoder': MeshoptDecoder,
    'meshopt.encoder': MeshoptEncoder,
  });
const document = await io.read(source);
await document.transform(...names.flatMap((name) => STEPS[name]()));
await io.write(out, document);
const used = document.getRoot().listExtensionsUsed();
console.log(JSON.stringify(used.map((extension) => extension.extensionName)));
