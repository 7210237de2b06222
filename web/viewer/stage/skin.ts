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
  Matrix3,
  RawShaderMaterial,
  RGBAFormat,
  Vector3,
  Vector4,
  type Texture,
} from 'three';
import type { Model, Part, Skin } from '../types/model';
import { heatColour } from './colours';
import type { Shadow } from './shadow';
import { FACE_FRAGMENT, FACE_VERTEX, GHOST_FRAGMENT } from './shaders/face';
import { imageTexture, numberTexture } from './textures';

/**
 * Corners (vertex, part) that parts share no more, and the triangles between them. Each part with a
 * skin of its own is a group, drawn with a material of its own.
 */
export function skinGeometry({ triangles, parts, neutral, uv }: Model): BufferGeometry {
  const corners: number[] = [];
  const index: number[] = [];
  const groups: (readonly [number, number])[] = [];
  const placeOf = new Int32Array(neutral.length / 3);
  parts.forEach(({ start, count, shown }, part) => {
    if (!shown) return;
    placeOf.fill(-1);
    groups.push([index.length, count]);
    for (let i = start; i < start + count; i += 1) {
      const vertex = triangles[i]!;
      if (placeOf[vertex] === -1) placeOf[vertex] = corners.push(vertex, part) / 2 - 1;
      index.push(placeOf[vertex]!);
    }
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute('corner', new BufferAttribute(Uint32Array.from(corners), 2));
  geometry.setIndex(new BufferAttribute(Uint32Array.from(index), 1));
  if (uv && isDressed(parts)) {
    const places = new Float32Array(corners.length);
    for (let i = 0; i < corners.length; i += 2)
      places.set(uv.subarray(2 * corners[i]!, 2 * corners[i]! + 2), i);
    geometry.setAttribute('uv', new BufferAttribute(places, 2));
  }
  if (isDressed(parts)) groups.forEach(([at, count], part) => geometry.addGroup(at, count, part));
  return geometry;
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

function isDressed(parts: readonly Part[]): boolean {
  return parts.some(({ skin }) => skin !== undefined);
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

/** The materials of a face: one for each part with a skin of its own, else one for all. */
export function skinMaterials(
  model: Model,
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
  };
  const shaders = {
    glslVersion: GLSL3,
    vertexShader: FACE_VERTEX,
    fragmentShader: FACE_FRAGMENT,
  } as const;
  if (!isDressed(model.parts)) {
    const uniforms = { ...shared, ...bareUniforms() };
    return [new RawShaderMaterial({ ...shaders, uniforms, side: DoubleSide })];
  }
  return model.parts.flatMap(({ skin }) => {
    if (!skin) return [];
    const clear = skin.opacity === 'blend';
    return new RawShaderMaterial({
      ...shaders,
      uniforms: { ...shared, ...skinUniforms(skin) },
      side: skin.doubleSided ? DoubleSide : FrontSide,
      transparent: clear,
      depthWrite: !clear,
    });
  });
}

function bareUniforms() {
  return {
    dressed: { value: false },
    unlit: { value: false },
    doubleSided: { value: false },
    image: { value: null as Texture | null },
    tint: { value: new Vector4(1, 1, 1, 1) },
    cutoff: { value: -1 },
    solid: { value: 1 },
    place: { value: new Matrix3() },
  };
}

function skinUniforms(skin: Skin) {
  const [a, b, c, d, x, y] = skin.place as [number, number, number, number, number, number];
  return {
    dressed: { value: true },
    unlit: { value: skin.unlit },
    doubleSided: { value: skin.doubleSided },
    image: { value: imageTexture(skin) },
    tint: { value: new Vector4(...skin.colour) },
    cutoff: { value: skin.opacity === 'mask' ? skin.cutoff : -1 },
    solid: { value: skin.opacity === 'blend' ? 0 : 1 },
    place: { value: new Matrix3().set(a, c, x, b, d, y, 0, 0, 1) },
  };
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
    against: { value: null },
    painting: { value: false },
    measuring: { value: false },
    flatShading: { value: false },
  };
}
