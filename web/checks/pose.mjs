// Poses an exported file with three.js, as a program that uses the extras would.
//
//   node checks/pose.mjs FILE OUT name=t …        weights of sliders, bent by the package for engines
//   node checks/pose.mjs FILE OUT --clip NAME --time SECONDS    plays an animation of the file
//
// OUT receives the positions of all vertices as little-endian float32 triples, mesh by mesh in the
// order of the file, in the units of the scene. Prints the number of vertices, morph targets and triangles as
// JSON.
import { readFile, writeFile } from 'node:fs/promises';
import { AnimationMixer, Vector3 } from 'three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { bendMesh } from '../../runtimes/js/three.js';

function usage() {
  console.error('usage: node checks/pose.mjs FILE OUT (name=t … | --clip NAME --time SECONDS)');
  process.exit(2);
}

async function load(path) {
  const bytes = await readFile(path);
  const content = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  return new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).parseAsync(content, '');
}

// As a player without bends would set them, and then the bends.
function setWeights(meshes, weights) {
  for (const mesh of meshes) {
    const nameOf = new Map((mesh.userData.elastomorph?.morphs ?? []).map((m) => [m.target, m.name]));
    for (const [target, i] of Object.entries(mesh.morphTargetDictionary))
      mesh.morphTargetInfluences[i] = weights.get(nameOf.get(target) ?? target) ?? 0;
    bendMesh(mesh);
    bendMesh(mesh);
  }
}

function play(gltf, name, seconds) {
  const clip = gltf.animations.find((animation) => animation.name === name);
  if (!clip) throw new Error(`there is no animation '${name}'`);
  const mixer = new AnimationMixer(gltf.scene);
  mixer.clipAction(clip).play();
  mixer.setTime(seconds);
}

function positions(mesh) {
  const count = mesh.geometry.attributes.position.count;
  const found = new Float32Array(3 * count);
  const vertex = new Vector3();
  mesh.updateWorldMatrix(true, false);
  for (let i = 0; i < count; i += 1)
    mesh.getVertexPosition(i, vertex).applyMatrix4(mesh.matrixWorld).toArray(found, 3 * i);
  return found;
}

const [path, out, ...rest] = process.argv.slice(2);
if (!out || rest.length === 0) usage();
const gltf = await load(path);
const meshes = [];
gltf.scene.traverse((object) => {
  if (object.isMesh) meshes.push(object);
});
const moving = meshes.filter((mesh) => mesh.morphTargetInfluences);
if (moving.length === 0) throw new Error(`${path} has no mesh with morph targets`);
if (rest[0] === '--clip') {
  if (rest[2] !== '--time') usage();
  play(gltf, rest[1], Number(rest[3]));
} else {
  const weights = rest.map((text) => text.match(/^(.*)=([^=]+)$/)?.slice(1) ?? usage());
  setWeights(moving, new Map(weights.map(([name, t]) => [name, Number(t)])));
}
// Primitives of one mesh share the vertices of the file, so any of them gives all its positions.
const shown = meshes.filter(
  ({ geometry }, i) =>
    meshes.findIndex((mesh) => mesh.geometry.attributes.position === geometry.attributes.position) ===
    i,
);
const counts = shown.map((mesh) => mesh.geometry.attributes.position.count);
await writeFile(out, Buffer.concat(shown.map((mesh) => Buffer.from(positions(mesh).buffer))));
console.log(
  JSON.stringify({
    vertices: counts.reduce((sum, count) => sum + count, 0),
    targets: Math.max(...moving.map((mesh) => mesh.morphTargetInfluences.length)),
    triangles: meshes.reduce((sum, mesh) => sum + (mesh.geometry.index?.count ?? 0) / 3, 0),
  }),
);
