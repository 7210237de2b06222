// What the shader is told of the looks of a surface.
import { Matrix3, Vector2, Vector3, Vector4, type Texture } from 'three';
import type { Layer, Skin } from '../types/model';
import type { Pass } from './passes';
import { LAYERS } from './shaders/dress';
import { imageTexture } from './textures';

const SHADINGS: readonly Skin['shading'][] = ['lit', 'unlit', 'toon'];
const COLOURS: readonly string[] = ['base', 'glow', 'shade'];
const CORE = 0.985; // opacity from which a surface that blends is solid

/** The values of one pass over a part. */
export function dressUniforms({ skin, kind }: Pass, tinted: boolean) {
  const layers = LAYERS.map((name) => skin.layers[name]);
  const textures = LAYERS.map(
    (name) => [name, { value: imageTexture(skin.layers[name], COLOURS.includes(name)) }] as const,
  );
  const cutoff = { solid: skin.opacity === 'mask' ? skin.cutoff : -1, core: CORE, clear: 1 / 255 };
  return {
    ...Object.fromEntries(textures),
    onto: { value: layers.map(placeOf) },
    set: { value: layers.map((layer) => layer?.set ?? -1) },
    tint: { value: new Vector4(...skin.colour) },
    cutoff: { value: cutoff[kind] },
    solid: { value: kind === 'clear' ? 0 : 1 },
    isTinted: { value: tinted },
    shading: { value: SHADINGS.indexOf(skin.shading) },
    bumpScale: { value: skin.bumps },
    glowing: { value: new Vector3(...skin.glow) },
    rough: { value: skin.roughness },
    metallic: { value: skin.metal },
    shine: { value: skin.shine },
    creaseDepth: { value: skin.creases },
    shadeTint: { value: new Vector3(...skin.shade) },
    edge: { value: new Vector2(...skin.edge) },
  };
}

/** The textures among the values of a material. */
export function texturesIn(uniforms: Readonly<Record<string, { value: unknown }>>): Texture[] {
  return LAYERS.flatMap((name) => (uniforms[name] ? [uniforms[name].value as Texture] : []));
}

/** Of the images of some parts with their smaller copies. */
export function imageBytes(skins: Iterable<Skin | undefined>): number {
  const images = new Set([...skins].flatMap((skin) => Object.values(skin?.layers ?? {})).map(imageOf));
  return [...images].reduce((sum, { width, height }) => sum + (16 / 3) * width * height, 0);
}

function imageOf({ image }: Layer): ImageBitmap {
  return image;
}

function placeOf(layer: Layer | undefined): Matrix3 {
  const [a, b, c, d, x, y] = (layer?.place ?? [1, 0, 0, 1, 0, 0]) as [
    ...[number, number, number],
    ...[number, number, number],
  ];
  return new Matrix3().set(a, c, x, b, d, y, 0, 0, 1);
}
