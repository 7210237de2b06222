// What a face is drawn with: its triangles by part, and the materials of solid and ghostly faces.
import {
  BufferAttribute,
  BufferGeometry,
  ClampToEdgeWrapping,
  DataTexture,
  DoubleSide,
  FrontSide,
  GLSL3,
  LessEqualDepth,
  LinearFilter,
  RawShaderMaterial,
  RGBAFormat,
  Vector3,
  type Texture,
} from 'three';
import type { Model } from '../types/model';
import { heatColour } from './colours';
import { dressUniforms } from './dress';
import type { Pass } from './passes';
import type { Shadow } from './shadow';
import { FACE_FRAGMENT, FACE_VERTEX, GHOST_FRAGMENT } from './shaders/face';
import { numberTexture } from './textures';

/**
 * Corners (vertex, part) that parts share no more, and the triangles between them. Each pass over a
 * part with a skin of its own is a group, drawn with a material of its own.
 */
export function skinGeometry(model: Model, passes: readonly Pass[]): BufferGeometry {
  const { triangles, parts, neutral } = model;
  const corners: number[] = [];
  const index: number[] = [];
  const starts: number[] = [];
  const placeOf = new Int32Array(neutral.length / 3);
  parts.forEach(({ start, count, shown }, part) => {
    starts.push(index.length);
    if (!shown) return;
    placeOf.fill(-1);
    for (let i = start; i < start + count; i += 1) {
      const vertex = triangles[i]!;
      if (placeOf[vertex] === -1) placeOf[vertex] = corners.push(vertex, part) / 2 - 1;
      index.push(placeOf[vertex]!);
    }
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute('corner', new BufferAttribute(Uint32Array.from(corners), 2));
  geometry.setIndex(new BufferAttribute(Uint32Array.from(index), 1));
  passes.forEach(({ part }, i) => geometry.addGroup(starts[part]!, parts[part]!.count, i));
  if (passes.length > 0) dressCorners(geometry, corners, model);
  return geometry;
}

/** What the images and colours of a file need to know of each corner. */
function dressCorners(geometry: BufferGeometry, corners: readonly number[], model: Model): void {
  const count = corners.length / 2;
  const gathered = <T extends Float32Array | Uint8Array>(from: T, width: number, into: T): T => {
    for (let i = 0; i < count; i += 1) {
      const vertex = corners[2 * i]!;
      into.set(from.subarray(width * vertex, width * (vertex + 1)), width * i);
    }
    return into;
  };
  model.uv.forEach((uv, set) => {
    const places = gathered(uv, 2, new Float32Array(2 * count));
    geometry.setAttribute(set === 0 ? 'uv' : 'uv2', new BufferAttribute(places, 2));
  });
  if (model.colours) {
    const tints = gathered(model.colours, 4, new Uint8Array(4 * count));
    geometry.setAttribute('tinted', new BufferAttribute(tints, 4, true));
  }
  if (!model.fileNormals) return;
  const ways = gathered(model.fileNormals, 3, new Float32Array(3 * count));
  const normals = new Int16Array(4 * count); // four, so that each starts at a whole word
  for (let i = 0; i < count; i += 1) {
    const [x, y, z] = ways.subarray(3 * i, 3 * i + 3) as unknown as [number, number, number];
    const scale = 32767 / (Math.hypot(x, y, z) || 1);
    normals.set([x * scale, y * scale, z * scale], 4 * i);
  }
  geometry.setAttribute('fileNormal', new BufferAttribute(normals, 4, true));
}

/** The triangles that cast a shadow: all but those that light shines through, which come last. */
export function castingGeometry(skin: BufferGeometry, { parts }: Model): BufferGeometry {
  const clear = parts
    .filter(({ shown, skin: own }) => shown && own?.opacity === 'blend')
    .reduce((sum, { count }) => sum + count, 0);
  if (clear === 0) return skin;
  const geometry = new BufferGeometry();
  const index = skin.index!.array as Uint32Array;
  geometry.setAttribute('corner', skin.getAttribute('corner'));
  geometry.setIndex(new BufferAttribute(index.slice(0, index.length - clear), 1));
  return geometry;
}

/** Colour, shine and eye of each part. */
export function partTexture({ parts }: Model): DataTexture {
  const width = Math.max(1, parts.length);
  const numbers = new Float32Array(8 * width);
  parts.forEach(({ colour, shine, eye }, i) => {
    numbers.set([...colour, shine], 4 * i);
    if (eye) numbers.set([...eye.middle, eye.radius], 4 * (width + i));
  });
  return numberTexture(numbers, width, 2, 'RGBA32F');
}

/** The colours of distances in a row. */
export function heatTexture(): DataTexture {
  const pixels = new Uint8Array(4 * 256);
  for (let i = 0; i < 256; i += 1) {
    pixels.set(
      [...heatColour(i / 255), 1].map((c) => Math.round(255 * c)),
      4 * i,
    );
  }
  const texture = new DataTexture(pixels, 256, 1, RGBAFormat);
  texture.minFilter = LinearFilter;
  texture.magFilter = LinearFilter;
  texture.wrapS = ClampToEdgeWrapping;
  texture.needsUpdate = true;
  return texture;
}

/** What all faces share. */
export interface Pictures {
  readonly heat: Texture;
  readonly matcap: Texture;
  readonly shadow: Shadow;
}

/** The materials of a face: one for each pass over a part with a skin of its own, else one for all. */
export function skinMaterials(
  model: Model,
  passes: readonly Pass[],
  parts: Texture,
  { heat, matcap, shadow }: Pictures,
): RawShaderMaterial[] {
  const shared = {
    ...shapeUniforms(),
    parts: { value: parts },
    heat: { value: heat },
    matcap: { value: matcap },
    inMatcap: { value: false },
    heatTop: { value: 1 },
    shadows: { value: shadow.map },
    ball: { value: shadow.ball },
    looks: shadow.looks,
  };
  const shaders = {
    glslVersion: GLSL3,
    vertexShader: FACE_VERTEX,
    fragmentShader: FACE_FRAGMENT,
  } as const;
  if (passes.length === 0) {
    return [new RawShaderMaterial({ ...shaders, uniforms: shared, side: DoubleSide })];
  }
  return passes.map((pass) => {
    const { skin, side, kind } = pass;
    const uniforms = { ...shared, ...dressUniforms(pass, model.colours !== null) };
    return new RawShaderMaterial({
      ...shaders,
      defines: { DRESSED: '' },
      uniforms,
      side,
      transparent: kind === 'clear',
      depthWrite: kind !== 'clear' || skin.covers,
    });
  });
}

/** For faces that are not there; `depthOnly` goes first, so that only their front shows. */
export function ghostMaterial(depthOnly: boolean): RawShaderMaterial {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: FACE_VERTEX,
    fragmentShader: GHOST_FRAGMENT,
    uniforms: {
      ...shapeUniforms(),
      tint: { value: new Vector3(1, 1, 1) },
      opacity: { value: 0.3 },
      apart: { value: 1 },
    },
    side: FrontSide,
    transparent: true,
    depthWrite: depthOnly,
    depthFunc: LessEqualDepth,
    colorWrite: !depthOnly,
  });
}

function shapeUniforms() {
  return {
    positions: { value: null },
    normals: { value: null },
    rest: { value: null },
    restNormals: { value: null },
    against: { value: null },
    painting: { value: false },
    measuring: { value: false },
    flatShading: { value: false },
  };
}
