// What a document says of the looks of its surfaces: base colours, images, opacity.
import type { Skin, Wrap } from '../types/model';
import { isEntry, type Entry, type GltfDocument } from './document';

const MOST_PIXELS = 8192 ** 2; // of an image that is shown
const LARGEST = 4096; // pixels on a side of what is kept of it
const WRAPS: Readonly<Record<number, Wrap>> = { 33071: 'clamp', 33648: 'mirror', 10497: 'repeat' };
const NEAREST = 9728;
const OPACITIES: Readonly<Record<string, Skin['opacity']>> = { MASK: 'mask', BLEND: 'blend' };

/** A surface that nothing is said of is white. */
export const PLAIN: Skin = {
  image: null,
  colour: [1, 1, 1, 1],
  opacity: 'opaque',
  cutoff: 0.5,
  doubleSided: false,
  unlit: false,
  wrap: ['repeat', 'repeat'],
  smooth: true,
  place: [1, 0, 0, 1, 0, 0],
};

/** The attribute with the coordinates by which a primitive shows the image of its base colour. */
export function shownCoordinates(file: GltfDocument, primitive: Entry): string {
  const material = file.items('materials')[Number(primitive['material'] ?? -1)];
  const texture = isEntry(material) ? textureOf(material) : {};
  const set = transformOf(texture)['texCoord'] ?? texture['texCoord'] ?? 0;
  const name = `TEXCOORD_${Number(set)}`;
  return isEntry(primitive['attributes']) && name in primitive['attributes'] ? name : 'TEXCOORD_0';
}

/** The looks of each material; null where no material shows an image: names tell more then. */
export async function readSkins(file: GltfDocument): Promise<Skin[] | null> {
  const materials = file.items('materials').map((entry) => (isEntry(entry) ? entry : {}));
  if (!materials.some((entry) => textureOf(entry)['index'] !== undefined)) return null;
  const images = new Map<unknown, Promise<ImageBitmap | null>>();
  const imageOf = (number: unknown) => {
    if (!images.has(number)) images.set(number, decoded(file, number));
    return images.get(number)!;
  };
  return Promise.all(materials.map((entry) => skinOf(file, entry, imageOf)));
}

async function skinOf(
  file: GltfDocument,
  entry: Entry,
  imageOf: (number: unknown) => Promise<ImageBitmap | null>,
): Promise<Skin> {
  const shading = objectIn(entry, 'pbrMetallicRoughness');
  const extensions = objectIn(entry, 'extensions');
  const shown = textureOf(entry);
  const texture = listed(file, 'textures', shown['index']);
  const sampler = listed(file, 'samplers', texture['sampler']);
  const webp = objectIn(objectIn(texture, 'extensions'), 'EXT_texture_webp');
  const cutoff = entry['alphaCutoff'];
  return {
    image: await imageOf(webp['source'] ?? texture['source']),
    colour: numbersIn(shading, 'baseColorFactor', [1, 1, 1, 1]) as Skin['colour'],
    opacity: OPACITIES[String(entry['alphaMode'])] ?? 'opaque',
    cutoff: typeof cutoff === 'number' ? cutoff : 0.5,
    doubleSided: entry['doubleSided'] === true,
    unlit: 'KHR_materials_unlit' in extensions || 'VRMC_materials_mtoon' in extensions,
    wrap: [wrap(sampler['wrapS']), wrap(sampler['wrapT'])],
    smooth: sampler['magFilter'] !== NEAREST,
    place: placeOf(transformOf(shown)),
  };
}

/** Scaled, then turned counter-clockwise as seen on the image, then moved. */
function placeOf(transform: Entry): number[] {
  const [x, y] = numbersIn(transform, 'offset', [0, 0]) as [number, number];
  const [across, down] = numbersIn(transform, 'scale', [1, 1]) as [number, number];
  const angle = transform['rotation'];
  const turn = typeof angle === 'number' ? angle : 0;
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  return [c * across, -s * across, s * down, c * down, x, y];
}

/** The pixels of an image; null, with a warning, where the browser cannot show them. */
async function decoded(file: GltfDocument, number: unknown): Promise<ImageBitmap | null> {
  if (number === undefined) return null;
  const told = (problem: string) => {
    console.warn(`${file.name}: image ${String(number)} ${problem}; only its colour is shown.`);
    return null;
  };
  const image = listed(file, 'images', number);
  const view = listed(file, 'bufferViews', image['bufferView']);
  const buffer = file.buffers[Number(view['buffer'] ?? -1)];
  const [start, length] = [Number(view['byteOffset'] ?? 0), Number(view['byteLength'])];
  if (!buffer || !(start >= 0 && start + length <= buffer.length))
    return told('is not in the file');
  const bytes = buffer.slice(start, start + length);
  try {
    const settings = { colorSpaceConversion: 'none', premultiplyAlpha: 'none' } as const;
    const whole = await createImageBitmap(new Blob([bytes]), settings);
    const { width, height } = whole;
    if (width * height > MOST_PIXELS) {
      whole.close();
      return told('is too large');
    }
    const shrink = LARGEST / Math.max(width, height);
    if (shrink >= 1) return whole;
    const size = {
      resizeWidth: Math.max(1, Math.round(width * shrink)),
      resizeHeight: Math.max(1, Math.round(height * shrink)),
    };
    return await createImageBitmap(whole, { ...settings, ...size });
  } catch {
    return told('is damaged or of a kind that this browser does not know');
  }
}

function textureOf(material: Entry): Entry {
  return objectIn(objectIn(material, 'pbrMetallicRoughness'), 'baseColorTexture');
}

function transformOf(texture: Entry): Entry {
  return objectIn(objectIn(texture, 'extensions'), 'KHR_texture_transform');
}

function wrap(given: unknown): Wrap {
  return WRAPS[Number(given)] ?? 'repeat';
}

function listed(file: GltfDocument, key: string, number: unknown): Entry {
  const found = typeof number === 'number' ? file.items(key)[number] : undefined;
  return isEntry(found) ? found : {};
}

function objectIn(holder: Entry, key: string): Entry {
  const found = holder[key];
  return isEntry(found) ? found : {};
}

function numbersIn(holder: Entry, key: string, otherwise: readonly number[]): readonly number[] {
  const found = holder[key];
  const right =
    Array.isArray(found) && found.length === otherwise.length && found.every(Number.isFinite);
  return right ? (found as number[]) : otherwise;
}
