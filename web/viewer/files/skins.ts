// What a document says of the looks of its surfaces: colours, images, opacity, light and shade.
import type { Layer, LayerName, Skin, Wrap } from '../types/model';
import { isEntry, listed, numberIn, numbersIn, objectIn, type Entry, type GltfDocument } from './document';
import { Images } from './images';
import { toonOf, type Toon } from './toon';

const WRAPS: Readonly<Record<number, Wrap>> = { 33071: 'clamp', 33648: 'mirror', 10497: 'repeat' };
const NEAREST = 9728;
const OPACITIES: Readonly<Record<string, Skin['opacity']>> = { MASK: 'mask', BLEND: 'blend' };
const ABOVE = 19; // rank of what blends and says nothing of its own

/** A surface that nothing is said of is white. */
export const PLAIN: Skin = {
  layers: {},
  colour: [1, 1, 1, 1],
  opacity: 'opaque',
  cutoff: 0.5,
  doubleSided: false,
  shading: 'lit',
  bumps: 1,
  glow: [0, 0, 0],
  roughness: 1,
  metal: 0,
  shine: 1,
  creases: 1,
  shade: [1, 1, 1],
  edge: [0, 0],
  rank: ABOVE,
  covers: false,
};

export interface Skins {
  readonly ofMaterial: readonly Skin[];
  /** What is not shown: a sentence each. */
  readonly notes: readonly string[];
}

/**
 * The attributes with the coordinates by which a primitive shows its images: one set or two, that of
 * the base colour first.
 */
export function shownCoordinates(file: GltfDocument, primitive: Entry): string[] {
  const number = primitive['material'];
  const material = listed(file, 'materials', number);
  const sets = setsOf(texturesOf(material, toonOf(file, Number(number ?? -1), material)));
  const given = objectIn(primitive, 'attributes');
  const names = sets.map((set) => `TEXCOORD_${set}`);
  return names.map((name) => (name in given ? name : 'TEXCOORD_0'));
}

/** The looks of each material; null where none has an image, a shade or a glow: names tell more then. */
export async function readSkins(file: GltfDocument, coloured: boolean): Promise<Skins | null> {
  const materials = file.items('materials').map((entry) => (isEntry(entry) ? entry : {}));
  const found = materials.map((entry, number) => {
    const toon = toonOf(file, number, entry);
    return { entry, toon, textures: texturesOf(entry, toon) };
  });
  const says = ({ entry, toon, textures }: (typeof found)[number]) =>
    toon !== null || textures.base !== undefined || skinOf(entry).glow.some((part) => part > 0);
  if (!coloured && !found.some(says)) return null;
  const wanted = found.flatMap(({ textures }) =>
    Object.values(textures).map((texture) => imageOf(file, texture)),
  );
  const images = new Images(file, wanted);
  const ofMaterial = await Promise.all(
    found.map(async ({ entry, toon, textures }) => {
      const names = Object.keys(textures) as LayerName[];
      const layers = await Promise.all(
        names.map((name) => layerOf(file, images, textures[name]!, setsOf(textures))),
      );
      const shown = names.flatMap((name, i) => (layers[i] ? [[name, layers[i]] as const] : []));
      return { ...skinOf(entry), ...toon?.looks, layers: Object.fromEntries(shown) };
    }),
  );
  return { ofMaterial, notes: images.notes };
}

type Textures = Readonly<Partial<Record<LayerName, Entry>>>;

/** References to textures by what they are for, those that name none left out. */
function texturesOf(entry: Entry, toon: Toon | null): Textures {
  const shading = shadingOf(entry);
  const given: Record<LayerName, Entry> = {
    base: objectIn(shading, 'baseColorTexture'),
    bumps: objectIn(entry, 'normalTexture'),
    glow: objectIn(entry, 'emissiveTexture'),
    finish: objectIn(shading, 'metallicRoughnessTexture'),
    creases: objectIn(entry, 'occlusionTexture'),
    shade: {},
  };
  const unlit = isUnlit(entry) && !toon;
  const named = Object.entries({ ...given, ...toon?.textures });
  const used = named.filter(([name, texture]) => 'index' in texture && (!unlit || name === 'base'));
  return Object.fromEntries(used);
}

function isUnlit(entry: Entry): boolean {
  return 'KHR_materials_unlit' in objectIn(entry, 'extensions');
}

/** The shading of a material; one of specular and glossiness as what it comes near to. */
function shadingOf(entry: Entry): Entry {
  const glossy = objectIn(entry, 'extensions')['KHR_materials_pbrSpecularGlossiness'];
  if (!isEntry(glossy)) return objectIn(entry, 'pbrMetallicRoughness');
  const { diffuseTexture, diffuseFactor } = glossy;
  return {
    ...(diffuseTexture !== undefined && { baseColorTexture: diffuseTexture }),
    baseColorFactor: diffuseFactor,
    roughnessFactor: 1 - numberIn(glossy, 'glossinessFactor', 1),
    metallicFactor: 0,
  };
}

function skinOf(entry: Entry): Skin {
  const shading = shadingOf(entry);
  const specular = objectIn(objectIn(entry, 'extensions'), 'KHR_materials_specular');
  const strong = objectIn(objectIn(entry, 'extensions'), 'KHR_materials_emissive_strength');
  const strength = numberIn(strong, 'emissiveStrength', 1);
  const glow = numbersIn(entry, 'emissiveFactor', [0, 0, 0]).map((part) => part * strength);
  return {
    ...PLAIN,
    colour: numbersIn(shading, 'baseColorFactor', [1, 1, 1, 1]) as Skin['colour'],
    opacity: OPACITIES[String(entry['alphaMode'])] ?? 'opaque',
    cutoff: numberIn(entry, 'alphaCutoff', 0.5),
    doubleSided: entry['doubleSided'] === true,
    shading: isUnlit(entry) ? 'unlit' : 'lit',
    bumps: numberIn(objectIn(entry, 'normalTexture'), 'scale', 1),
    glow: glow as unknown as Skin['glow'],
    roughness: numberIn(shading, 'roughnessFactor', 1),
    metal: numberIn(shading, 'metallicFactor', 1),
    shine: numberIn(specular, 'specularFactor', 1),
    creases: numberIn(objectIn(entry, 'occlusionTexture'), 'strength', 1),
  };
}

async function layerOf(
  file: GltfDocument,
  images: Images,
  reference: Entry,
  sets: readonly number[],
): Promise<Layer | null> {
  const image = await images.of(imageOf(file, reference));
  if (!image) return null;
  const texture = listed(file, 'textures', reference['index']);
  const sampler = listed(file, 'samplers', texture['sampler']);
  return {
    image,
    wrap: [wrap(sampler['wrapS']), wrap(sampler['wrapT'])],
    smooth: sampler['magFilter'] !== NEAREST,
    place: placeOf(transformOf(reference)),
    set: Math.max(0, sets.indexOf(setOf(reference))),
  };
}

/** The number of the image that a texture shows; -1 where it names none. */
function imageOf(file: GltfDocument, reference: Entry): number {
  const texture = listed(file, 'textures', reference['index']);
  const extensions = objectIn(texture, 'extensions');
  const kinds = ['EXT_texture_webp', 'EXT_texture_avif'];
  if (texture['source'] === undefined) kinds.push('KHR_texture_basisu');
  const other = kinds.find((name) => name in extensions);
  return numberIn(other ? objectIn(extensions, other) : texture, 'source', -1);
}

/** Scaled, then turned counter-clockwise as seen on the image, then moved. */
function placeOf(transform: Entry): number[] {
  const [x, y] = numbersIn(transform, 'offset', [0, 0]) as [number, number];
  const [across, down] = numbersIn(transform, 'scale', [1, 1]) as [number, number];
  const turn = numberIn(transform, 'rotation', 0);
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  return [c * across, -s * across, s * down, c * down, x, y];
}

function setOf(reference: Entry): number {
  return Number(transformOf(reference)['texCoord'] ?? reference['texCoord'] ?? 0);
}

/** The sets of coordinates that textures ask for: the first two, that of the base first. */
function setsOf(textures: Textures): number[] {
  return [...new Set(Object.values(textures).map(setOf))].slice(0, 2);
}

function transformOf(texture: Entry): Entry {
  return objectIn(objectIn(texture, 'extensions'), 'KHR_texture_transform');
}

function wrap(given: unknown): Wrap {
  return WRAPS[Number(given)] ?? 'repeat';
}
