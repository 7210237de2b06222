// Textures whose texels are numbers.
import {
  DataTexture,
  FloatType,
  NearestFilter,
  RGBAFormat,
  RGBFormat,
  RGFormat,
  RGIntegerFormat,
  UnsignedIntType,
  type PixelFormat,
} from 'three';

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
