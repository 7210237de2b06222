// Loads a GLB file in three.js and writes it again by its exporter, in grey: node checks/three_export.mjs IN OUT
import { readFile, writeFile } from 'node:fs/promises';
import { MeshStandardMaterial, Texture } from 'three';
import { GLTFExporter } from 'three/addons/exporters/GLTFExporter.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

// The exporter puts its bytes together by what browsers have.
globalThis.FileReader = class {
  async readAsArrayBuffer(blob) {
    this.result = await blob.arrayBuffer();
    this.onloadend();
  }
};

const [path, out] = process.argv.slice(2);
const bytes = await readFile(path);
const content = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
const loader = new GLTFLoader();
loader.register(() => ({ name: 'no textures', loadTexture: async () => new Texture() }));
const { scene, animations } = await loader.parseAsync(content, '');
scene.traverse((object) => {
  if (object.isMesh) object.material = new MeshStandardMaterial();
});
const written = await new GLTFExporter().parseAsync(scene, { binary: true, animations });
await writeFile(out, Buffer.from(written));
