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
import type { Shadow } from './shadow';
import { FACE_FRAGMENT, FACE_VERTEX, GHOST_FRAGMENT } from './shaders/face';
import { numberTexture } from './textures';

/** Corners (vertex, part) that parts share no more, and the triangles between them. */
export function skinGeometry({ triangles, parts, neutral }: Model): BufferGeometry {
  const corners: number[] = [];
  const index: number[] = [];
  const placeOf = new Int32Array(neutral.length / 3);
  parts.forEach(({ start, count, shown }, part) => {
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

export function skinMaterial(
  parts: Texture,
  { heat, matcap, shadow }: Pictures,
): RawShaderMaterial {
  return new RawShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: FACE_VERTEX,
    fragmentShader: FACE_FRAGMENT,
    uniforms: {
      ...shapeUniforms(),
      parts: { value: parts },
      heat: { value: heat },
      matcap: { value: matcap },
      inMatcap: { value: false },
      heatTop: { value: 1 },
      shadows: { value: shadow.map },
      ball: { value: shadow.ball },
    },
    side: DoubleSide,
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
    against: { value: null },
    painting: { value: false },
    measuring: { value: false },
    flatShading: { value: false },
  };
}
