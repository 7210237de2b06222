// Poses a plain GLB file as three.js or Babylon.js does, skins applied.
//
//   node checks/play.mjs three|babylon FILE REQUESTS OUT
//
// REQUESTS is a JSON list of {weights: {node: [w, …]}, clip: number or null, time: seconds, bend:
// boolean}: the weights of all morph targets by number of the node; then a clip of the file plays
// over them, if one is named; then the package for engines bends, if asked, twice. OUT receives, for each request, the world positions of all primitives with morph
// targets as little-endian float64 triples. Prints [[node, primitive, vertices], …], in the same
// order, as JSON. Nodes of the file are named node0, node1, … and its clips clip0, clip1, …: names
// are all that Babylon.js keeps of their numbers.
import { open, readFile } from 'node:fs/promises';

const PLAYERS = {
  three: () => import('./players/three.mjs'),
  babylon: () => import('./players/babylon.mjs'),
};

const [player, path, requests, out] = process.argv.slice(2);
if (!(player in PLAYERS) || !out) {
  console.error('usage: node checks/play.mjs three|babylon FILE REQUESTS OUT');
  process.exit(2);
}
const { load } = await PLAYERS[player]();
const bytes = await readFile(path);
const stage = await load(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
stage.parts.sort((a, b) => a.node - b.node || a.primitive - b.primitive);
const written = await open(out, 'w');
for (const { weights, clip, time, bend } of JSON.parse(await readFile(requests, 'utf8'))) {
  stage.stop();
  for (const part of stage.parts) part.setWeights(weights[part.node]);
  if (clip !== null) stage.play(clip, time);
  if (bend) for (const part of [...stage.parts, ...stage.parts]) part.bend();
  stage.update();
  for (const part of stage.parts) await written.write(Buffer.from(part.positions().buffer));
}
await written.close();
console.log(JSON.stringify(stage.parts.map((part) => [part.node, part.primitive, part.count])));
