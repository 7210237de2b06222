// MToon, the shading of VRM characters: light and shade as two flat colours with an edge between.
import type { Skin } from '../types/model';
import { isEntry, listed, numberIn, numbersIn, objectIn, type Entry, type GltfDocument } from './document';
import { linear } from './looks';

/** What a VRM file says of a material, in the words of glTF. */
export interface Toon {
  /** References to textures, as glTF's own materials have them. */
  readonly textures: { readonly shade?: Entry; readonly bumps?: Entry; readonly glow?: Entry };
  readonly looks: Partial<Skin>;
}

const LATER = 10; // what blends without covering comes after what covers

/** The looks of a material in MToon of VRM 1.0 or 0.x; null where it has none. */
export function toonOf(file: GltfDocument, number: number, entry: Entry): Toon | null {
  const one = objectIn(entry, 'extensions')['VRMC_materials_mtoon'];
  if (isEntry(one)) return toonOfOne(one);
  const zero = toonPropertiesOf(file, number);
  return 'shader' in zero ? toonOfZero(file, zero) : null;
}

/** What VRM 0.x says of a material in MToon; empty for any other. */
export function toonPropertiesOf(file: GltfDocument, number: number): Entry {
  const vrm = objectIn((file.value('extensions') ?? {}) as Entry, 'VRM');
  const properties = vrm['materialProperties'];
  const zero = Array.isArray(properties) ? (properties[number] as unknown) : undefined;
  return isEntry(zero) && zero['shader'] === 'VRM/MToon' ? zero : {};
}

function toonOfOne(toon: Entry): Toon {
  const covers = toon['transparentWithZWrite'] === true;
  const shift = numberIn(toon, 'shadingShiftFactor', 0);
  return {
    textures: { shade: objectIn(toon, 'shadeMultiplyTexture') },
    looks: {
      shading: 'toon',
      shade: numbersIn(toon, 'shadeColorFactor', [0, 0, 0]) as Skin['shade'],
      edge: edgeOf(shift, numberIn(toon, 'shadingToonyFactor', 0.9)),
      rank: (covers ? 0 : 2 * LATER) + numberIn(toon, 'renderQueueOffsetNumber', 0),
      covers,
    },
  };
}

/** Colours of VRM 0.x are those of screens; its queue counts from 2,000 for opaque ones. */
function toonOfZero(file: GltfDocument, zero: Entry): Toon {
  const [numbers, colours] = [objectIn(zero, 'floatProperties'), objectIn(zero, 'vectorProperties')];
  const textures = objectIn(zero, 'textureProperties');
  const reference = (name: string): Entry => {
    const index = textures[name];
    const known = Object.keys(listed(file, 'textures', index)).length > 0;
    return known ? { index } : {};
  };
  const covers = numbers['_BlendMode'] === 3;
  const before = numberIn(numbers, '_ShadeShift', 0);
  const toony = numberIn(numbers, '_ShadeToony', 0.9);
  const sharp = toony + (1 - toony) * (0.5 + 0.5 * before);
  return {
    textures: {
      shade: reference('_ShadeTexture'),
      bumps: reference('_BumpMap'),
      glow: reference('_EmissionMap'),
    },
    looks: {
      shading: 'toon',
      shade: linear(numbersIn(colours, '_ShadeColor', [0.97, 0.81, 0.86, 1])),
      glow: linear(numbersIn(colours, '_EmissionColor', [0, 0, 0, 1])),
      bumps: numberIn(numbers, '_BumpScale', 1),
      edge: edgeOf(-before - (1 - sharp), sharp),
      rank: numberIn(zero, 'renderQueue', 3000) - (covers ? 2500 : 3000) + (covers ? 0 : 2 * LATER),
      covers,
    },
  };
}

/** Cosines to the light between which shade turns to light. */
function edgeOf(shift: number, toony: number): Skin['edge'] {
  const half = Math.max(1 - toony, 1e-3);
  return [-half - shift, half - shift];
}
