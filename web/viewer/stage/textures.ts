// Textures whose texels are numbers.
import {
  ClampToEdgeWrapping,
  DataTexture,
  FloatType,
  LinearFilter,
  LinearMipmapLinearFilter,
  MirroredRepeatWrapping,
  NearestFilter,
  NoColorSpace,
  RepeatWrapping,
  RGBAFormat,
  RGBFormat,
  RGFormat,
  RGIntegerFormat,
  TextureSource,
  SRGBColorSpace,
  Texture,
  UnsignedIntType,
  type PixelFormat,
  type Wrapping,
} from 'three';
import type { Layer, Wrap } from '../types/model';

const WRAPS: Readonly<Record<Wrap, Wrapping>> = {
  repeat: RepeatWrapping,
  mirror: MirroredRepeatWrapping,
  clamp: ClampToEdgeWrapping,
};

/** One upload an image, however many surfaces show it. */
const sources = new WeakMap<ImageBitmap, TextureSource<ImageBitmap>>();

/** The image of a layer; white where there is none. Colours are decoded, other numbers are not. */
export function imageTexture(layer: Layer | undefined, colours: boolean): Texture {
  if (!layer) {
    const white = new DataTexture(new Uint8Array([255, 255, 255, 255]), 1, 1);
    white.needsUpdate = true;
    return white;
  }
  const { image, wrap, smooth } = layer;
  const texture = new Texture();
  if (!sources.has(image)) sources.set(image, new TextureSource(image));
  texture.source = sources.get(image)!;
  texture.colorSpace = colours ? SRGBColorSpace : NoColorSpace;
  texture.flipY = false;
  texture.wrapS = WRAPS[wrap[0]];
  texture.wrapT = WRAPS[wrap[1]];
  texture.magFilter = smooth ? LinearFilter : NearestFilter;
  texture.minFilter = smooth ? LinearMipmapLinearFilter : NearestFilter;
  texture.generateMipmaps = smooth;
  texture.anisotropy = smooth ? 4 : 1;
  texture.needsUpdate = true;
  return texture;
}

type Format = 'RGB32F' | 'RGBA32F' | 'RG32F' | 'RG32UI';

const FORMATS: Readonly<Record<Format, number>> = {
  RGB32F: RGBFormat,
  RGBA32F: RGBAFormat,
  RG32F: RGFormat,
  RG32UI: RGIntegerFormat,
};
const CHANNELS: Readonly<Record<Format, number>> = { RGB32F: 3, RGBA32F: 4, RG32F: 2, RG32UI: 2 };

/** A texture over numbers that fill it exactly. */
export function numberTexture(
  numbers: Float32Array | Uint32Array,
  width: number,
  rows: number,
  format: Format,
): DataTexture {
  const type = format === 'RG32UI' ? UnsignedIntType : FloatType;
  const texture = new DataTexture(
    numbers as Float32Array<ArrayBuffer>,
    width,
    rows,
    FORMATS[format] as PixelFormat,
    type,
  );
  texture.internalFormat = format;
  texture.minFilter = NearestFilter;
  texture.magFilter = NearestFilter;
  texture.unpackAlignment = 4;
  texture.needsUpdate = true;
  return texture;
}

/** Numbers followed by zeros, so that they fill a texture. */
export function padded<T extends Float32Array | Uint32Array>(
  numbers: T,
  width: number,
  rows: number,
  format: Format,
): T {
  const size = CHANNELS[format] * width * rows;
  if (numbers.length === size) return numbers;
  const filled = numbers instanceof Float32Array ? new Float32Array(size) : new Uint32Array(size);
  filled.set(numbers);
  return filled as T;
}
