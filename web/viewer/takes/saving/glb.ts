// A take as the animation of the rig's own file, for players that know nothing of bends.
import { Quaternion } from 'three';
import { openContainer, refuse } from '../../files/container';
import { GltfDocument, isEntry, type Entry } from '../../files/document';
import { roots } from '../../files/nodes';
import { targetNamesOf } from '../../files/surface';
import { headNode, mayTurn, restOf } from '../../files/turning';
import { framedBox } from '../../rig/framed';
import { headOf, headRotation } from '../../rig/head';
import type { Clip, Model } from '../../types/model';

const FLOAT = 5126;
const STILL = { above: new Quaternion(), own: new Quaternion() };
const [GLTF, JSON_CHUNK, BINARY_CHUNK] = [0x46546c67, 0x4e4f534a, 0x004e4942];

/** The lists of a document that grow, and what is put behind its bytes. */
interface Growing {
  readonly views: unknown[];
  readonly accessors: unknown[];
  readonly bytes: Uint8Array<ArrayBuffer>[];
  size: number;
}

/** The file of a rig with one more animation, the first of its list; all else is as it was. */
export async function takeAsGlb(clip: Clip, model: Model): Promise<Blob> {
  const name = `${model.name}.glb`;
  if (!model.file) refuse(name, 'its file is not at hand. Open it again, then the take.');
  const content = await openContainer(name, await model.file.arrayBuffer());
  const file = new GltfDocument(content);
  const [first, ...others] = file.items('buffers');
  if (!isEntry(first) || first['uri'] !== undefined)
    refuse(name, 'it is glTF as text. Export it as glTF Binary (.glb), then open that.');
  const held = content.buffers[0] as Uint8Array<ArrayBuffer>;
  const grown: Growing = {
    views: [...file.items('bufferViews')],
    accessors: [...file.items('accessors')],
    bytes: [held],
    size: held.length,
  };
  const animation = animationOf(file, grown, clip, model);
  const turned = turnedNodes(file, grown, clip, model, animation);
  const kept = file.items('animations').filter((one) => isEntry(one) && one['name'] !== clip.name);
  return container(
    {
      ...content.document,
      buffers: [{ ...first, byteLength: grown.size }, ...others],
      bufferViews: grown.views,
      accessors: grown.accessors,
      animations: [animation, ...kept],
      ...turned,
    },
    grown,
  );
}

function animationOf(
  file: GltfDocument,
  grown: Growing,
  clip: Clip,
  model: Model,
): { name: string; channels: unknown[]; samplers: unknown[] } {
  const { times } = clip;
  const weights = targetWeights(clip, model);
  const seconds = Float32Array.from(times, (time) => time - times[0]!);
  const ends = { min: [0], max: [seconds.at(-1)] };
  const input = accessor(grown, seconds, ends);
  const columns = new Map(model.bender.targets.map((target, i) => [target, i]));
  const samplers: unknown[] = [];
  const channels: unknown[] = [];
  const samplerOf = new Map<unknown, number>();
  file.items('nodes').forEach((node, number) => {
    if (!isEntry(node) || node['mesh'] === undefined) return;
    const mesh = file.item('meshes', node['mesh'], 'a node');
    const names = targetNamesOf(file, mesh);
    if (names.length === 0) return;
    if (!samplerOf.has(mesh)) {
      const places = names.map((target) => columns.get(target) ?? -1);
      const values = weights.flatMap((all) => places.map((place) => all[place] ?? 0));
      samplerOf.set(mesh, samplers.length);
      const output = accessor(grown, Float32Array.from(values), {});
      samplers.push({ input, interpolation: 'LINEAR', output });
    }
    channels.push({ sampler: samplerOf.get(mesh), target: { node: number, path: 'weights' } });
  });
  return { name: clip.name, channels, samplers };
}

/**
 * Lets the head turn with its take: its bone, or a node in the neck that all hangs below. What of the
 * document is another then.
 */
function turnedNodes(
  file: GltfDocument,
  grown: Growing,
  clip: Clip,
  model: Model,
  { channels, samplers }: { channels: unknown[]; samplers: unknown[] },
): Entry {
  const heads = Array.from(clip.times, (time) => headOf(clip, time) ?? ([0, 0, 0] as const));
  const nodes = [...file.items('nodes')];
  if (!nodes.length || !heads.some((head) => head.some(Boolean))) return {};
  const bone = headNode(file, mayTurn(file));
  const { above, own } = bone === undefined ? STILL : restOf(file, bone);
  let last = new Quaternion();
  const values = heads.flatMap((head) => {
    const seen = above.clone().invert().multiply(headRotation(head)).multiply(above).multiply(own);
    if (seen.dot(last) < 0) seen.set(-seen.x, -seen.y, -seen.z, -seen.w);
    last = seen;
    return seen.toArray();
  });
  const output = accessor(grown, Float32Array.from(values), {}, 4);
  const { input } = samplers[0] as Entry;
  samplers.push({ input, interpolation: 'LINEAR', output });
  const node = bone ?? nodes.length;
  channels.push({ sampler: samplers.length - 1, target: { node, path: 'rotation' } });
  if (bone !== undefined) return {};
  const { neck } = framedBox(model);
  nodes.push({ name: 'head', translation: neck.toArray(), children: [node + 1] });
  nodes.push({ translation: neck.negate().toArray(), children: roots(file) });
  const scenes = [...(file.items('scenes').length ? file.items('scenes') : [{}])] as Entry[];
  const shown = Number(file.value('scene') ?? 0);
  scenes[shown] = { ...scenes[shown], nodes: [node] };
  return { nodes, scenes, scene: shown };
}

/** The weights of all targets, bends among them, at each key. */
function targetWeights({ tracks, times }: Clip, { bender }: Model): Float64Array[] {
  const own = bender.sliders.map((slider) => tracks.get(slider));
  return Array.from(times, (_, i) => bender.weights(own.map((track) => track?.[i] ?? 0)));
}

/** Numbers behind the bytes of a file; its number among the accessors. */
function accessor(
  grown: Growing,
  values: Float32Array<ArrayBuffer>,
  ends: Entry,
  width: 1 | 4 = 1,
): number {
  pad(grown, 0);
  grown.views.push({ buffer: 0, byteOffset: grown.size, byteLength: values.byteLength });
  grown.bytes.push(new Uint8Array(values.buffer));
  grown.size += values.byteLength;
  const bufferView = grown.views.length - 1;
  grown.accessors.push({
    bufferView,
    componentType: FLOAT,
    count: values.length / width,
    type: width === 1 ? 'SCALAR' : 'VEC4',
    ...ends,
  });
  return grown.accessors.length - 1;
}

function pad(grown: Growing, byte: number): void {
  const missing = -grown.size & 3;
  grown.bytes.push(new Uint8Array(missing).fill(byte));
  grown.size += missing;
}

function container(document: Entry, binary: Growing): Blob {
  pad(binary, 0);
  const text = new TextEncoder().encode(JSON.stringify(document));
  const json: Growing = { ...binary, bytes: [text], size: text.length };
  pad(json, 0x20);
  const words = (...numbers: number[]) => Uint32Array.from(numbers); // little-endian, as browsers are
  const whole = 28 + json.size + binary.size;
  return new Blob(
    [
      ...[words(GLTF, 2, whole, json.size, JSON_CHUNK), ...json.bytes],
      ...[words(binary.size, BINARY_CHUNK), ...binary.bytes],
    ],
    { type: 'model/gltf-binary' },
  );
}
