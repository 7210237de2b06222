// Poses an exported file with Babylon.js, without a graphics card.
//
//   node checks/babylon.mjs FILE OUT name=t …     weights of sliders, bent by the package for engines
//
// OUT receives the positions of all vertices of the first mesh with morph targets as little-endian
// float32 triples, in the order of the file. Prints the number of vertices and morph targets as JSON.
import { readFile, writeFile } from 'node:fs/promises';
import { NullEngine } from '@babylonjs/core/Engines/nullEngine.js';
import { LoadAssetContainerAsync } from '@babylonjs/core/Loading/sceneLoader.js';
import { Scene } from '@babylonjs/core/scene.js';
import '@babylonjs/core/Materials/standardMaterial.js';
import '@babylonjs/loaders/glTF/2.0/index.js';
import { registerGLTFExtension } from '@babylonjs/loaders/glTF/2.0/glTFLoaderExtensionRegistry.js';
import { bendMesh, keepExtras } from '../../runtimes/js/babylon.js';

const [path, out, ...rest] = process.argv.slice(2);
const weights = rest.map((text) => text.match(/^(.*)=([^=]+)$/)?.slice(1));
if (!out || weights.length === 0 || weights.includes(undefined)) {
  console.error('usage: node checks/babylon.mjs FILE OUT name=t …');
  process.exit(2);
}

registerGLTFExtension('elastomorph', false, keepExtras);
const scene = new Scene(new NullEngine());
scene.useRightHandedSystem = true; // the axes of glTF
const content = new Uint8Array(await readFile(path));
const container = await LoadAssetContainerAsync(content, scene, { pluginExtension: '.glb' });
container.addAllToScene();
const meshes = scene.meshes.filter((mesh) => mesh.morphTargetManager?.numTargets > 0);
if (meshes.length === 0) throw new Error(`${path} has no mesh with morph targets`);
const slider = new Map(weights.map(([name, t]) => [name, Number(t)]));
for (const mesh of meshes) {
  const nameOf = new Map((mesh.metadata?.elastomorph?.morphs ?? []).map((m) => [m.target, m.name]));
  for (let i = 0; i < mesh.morphTargetManager.numTargets; i += 1) {
    const target = mesh.morphTargetManager.getTarget(i);
    target.influence = slider.get(nameOf.get(target.name) ?? target.name) ?? 0;
  }
}
scene.onBeforeRenderObservable.add(() => scene.meshes.forEach(bendMesh));
scene.onBeforeRenderObservable.notifyObservers(scene);
scene.onBeforeRenderObservable.notifyObservers(scene);
const found = Float32Array.from(meshes[0].getPositionData(true, true));
await writeFile(out, found);
console.log(
  JSON.stringify({
    vertices: found.length / 3,
    targets: meshes[0].morphTargetManager.numTargets,
  }),
);
process.exit(0);
