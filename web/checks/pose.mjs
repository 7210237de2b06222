// Poses an exported file with three.js, as a program that uses the extras would.
//
//   node checks/pose.mjs FILE OUT name=t …        weights of sliders: Δ gets t, bends get b_k(t)
//   node checks/pose.mjs FILE OUT --clip NAME --time SECONDS    plays an animation of the file
//
// OUT receives the positions of all vertices as little-endian float32 triples, in the order of the
// file. Prints the number of vertices, morph targets and triangles as JSON.
import { readFile, writeFile } from 'node:fs/promises';
import { AnimationMixer, Vector3 } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

function usage() {
  console.error('usage: node checks/pose.mjs FILE OUT (name=t … | --clip NAME --time SECONDS)');
  process.exit(2);
}

async function load(path) {
  const bytes = await readFile(path);
  const content = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength);
  return new GLTFLoader().parseAsync(content, '');
}

// The value of a piecewise polynomial that is zero at both ends and straight beyond them.
function bendWeight({ breaks, coefficients }, t) {
  if (t < 0 || t > 1) {
    const end = t < 0 ? 0 : 1;
    return (t - end) * slope(breaks, coefficients, end);
  }
  const piece = pieceAt(breaks, t);
  const s = t - breaks[piece];
  return coefficients[piece].reduceRight((sum, a) => sum * s + a, 0);
}

function slope(breaks, coefficients, t) {
  const piece = pieceAt(breaks, t);
  const s = t - breaks[piece];
  return coefficients[piece].reduceRight((sum, a, n) => (n === 0 ? sum : sum * s + n * a), 0);
}

function pieceAt(breaks, t) {
  let piece = 0;
  while (piece < breaks.length - 2 && breaks[piece + 1] <= t) piece += 1;
  return piece;
}

function setWeights(meshes, weights) {
  for (const mesh of meshes) {
    const { morphTargetDictionary: number, morphTargetInfluences: influences } = mesh;
    for (const morph of mesh.userData.elastomorph.morphs) {
      const t = weights.get(morph.name) ?? 0;
      influences[number[morph.target]] = t;
      for (const { target, curve } of morph.bends ?? []) {
        influences[number[target]] = bendWeight(curve, t);
      }
    }
  }
}

function play(gltf, name, seconds) {
  const clip = gltf.animations.find((animation) => animation.name === name);
  if (!clip) throw new Error(`there is no animation '${name}'`);
  const mixer = new AnimationMixer(gltf.scene);
  mixer.clipAction(clip).play();
  mixer.setTime(seconds);
}

// All primitives share the vertices of the file, so any of them gives all positions.
function positions(mesh) {
  const count = mesh.geometry.attributes.position.count;
  const found = new Float32Array(3 * count);
  const vertex = new Vector3();
  for (let i = 0; i < count; i += 1) mesh.getVertexPosition(i, vertex).toArray(found, 3 * i);
  return found;
}

const [path, out, ...rest] = process.argv.slice(2);
if (!out || rest.length === 0) usage();
const gltf = await load(path);
const meshes = [];
gltf.scene.traverse((object) => {
  if (object.morphTargetInfluences) meshes.push(object);
});
if (meshes.length === 0) throw new Error(`${path} has no mesh with morph targets`);
if (rest[0] === '--clip') {
  if (rest[2] !== '--time') usage();
  play(gltf, rest[1], Number(rest[3]));
} else {
  const weights = rest.map((text) => text.match(/^(.*)=([^=]+)$/)?.slice(1) ?? usage());
  setWeights(meshes, new Map(weights.map(([name, t]) => [name, Number(t)])));
}
const found = positions(meshes[0]);
await writeFile(out, found);
console.log(
  JSON.stringify({
    vertices: found.length / 3,
    targets: meshes[0].morphTargetInfluences.length,
    triangles: meshes.reduce((sum, mesh) => sum + (mesh.geometry.index?.count ?? 0) / 3, 0),
  }),
);
