// Prints, as JSON, the bytes that three.js puts on a graphics card for the morph targets of files,
// plain or packed by meshoptimizer: `node checks/morph_textures.mjs FILE …`. What makes the textures
// is the renderer's own part, asked for every mesh as if it were drawn.
import { readFile } from 'node:fs/promises';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { WebGLMorphtargets } from 'three/src/renderers/webgl/WebGLMorphtargets.js';

const WIDEST = 16384; // what nearly every card has

const bytes = {};
for (const path of process.argv.slice(2)) {
  const own = await readFile(path);
  const content = own.buffer.slice(own.byteOffset, own.byteOffset + own.byteLength);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder);
  const { scene } = await loader.parseAsync(content, '');
  const sizes = new Map();
  const setValue = (_, name, value) => {
    if (name === 'morphTargetsTexture') sizes.set(value, value.image.data.byteLength);
  };
  const program = { getUniforms: () => ({ setValue }) };
  const targets = WebGLMorphtargets(null, { maxTextureSize: WIDEST }, null);
  scene.traverse((mesh) => {
    if (mesh.morphTargetInfluences) targets.update(mesh, mesh.geometry, program);
  });
  bytes[path] = [...sizes.values()].reduce((sum, size) => sum + size, 0);
}
console.log(JSON.stringify(bytes));
