// What a VRM player does to the weights of morph targets, without and with the package for engines.
//
//   node checks/vrm.mjs FILE name=value …     values of expressions
//
// Prints, for each primitive with morph targets, {node, alone, bent} as JSON: the weights that the
// player sets, and what they are after some frames in which the package has bent the mesh.
import { readFile } from 'node:fs/promises';
import { VRMExpressionLoaderPlugin } from '@pixiv/three-vrm-core';
import { Texture } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { bendMesh } from '../../runtimes/js/three.js';

const [path, ...rest] = process.argv.slice(2);
const bytes = await readFile(path);
const loader = new GLTFLoader();
loader.register((parser) => new VRMExpressionLoaderPlugin(parser));
loader.register(() => ({ name: 'no textures', loadTexture: async () => new Texture() }));
const content = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
const { scene, parser, userData } = await loader.parseAsync(content, '');
const player = userData.vrmExpressionManager;
const meshes = [];
scene.traverse((mesh) => {
  if (mesh.morphTargetInfluences) meshes.push(mesh);
});

function nodeOf(mesh) {
  const { nodes } = parser.associations.get(mesh) ?? {};
  return nodes ?? nodeOf(mesh.parent);
}

const values = rest.map((text) => text.split('='));
function frame(valueOf) {
  for (const [name, value] of values) player.setValue(name, valueOf(Number(value)));
  player.update();
}

frame((value) => value);
const alone = meshes.map((mesh) => [...mesh.morphTargetInfluences]);
// From other values to these, so that what stays of a frame before would show.
for (const valueOf of [(value) => 1 - value, (value) => value, (value) => value]) {
  frame(valueOf);
  scene.traverse(bendMesh);
}
console.log(
  JSON.stringify(
    meshes.map((mesh, i) => ({
      node: nodeOf(mesh),
      alone: alone[i],
      bent: mesh.morphTargetInfluences,
    })),
  ),
);
