// Wireframe and loops: lines between vertices, which follow the pose by themselves.
import {
  BufferAttribute,
  Color,
  DoubleSide,
  GLSL3,
  InstancedBufferAttribute,
  InstancedBufferGeometry,
  Mesh,
  RawShaderMaterial,
  SRGBColorSpace,
  Vector2,
  Vector3,
  type Texture,
} from 'three';
import type { Model } from '../types/model';
import { loopColours } from './colours';
import { darkVertices } from './darkness';
import { EDGE_FRAGMENT, EDGE_VERTEX } from './shaders/edges';

const LIGHT = 8; // times as bright as a dark line

type Colour = readonly [number, number, number];

interface Style {
  readonly width: number; // CSS pixels
  readonly opacity: number;
  readonly lift: number; // share of the distance to the eye by which it is nearer than the skin
  readonly fade: number; // CSS pixels below which a line is the fainter the shorter it is
}

/** Lines between pairs of vertices. */
export class Edges {
  readonly mesh: Mesh<InstancedBufferGeometry, RawShaderMaterial>;

  constructor(
    ends: Uint32Array,
    tints: Float32Array,
    private readonly style: Style,
  ) {
    const geometry = new InstancedBufferGeometry();
    geometry.setIndex(new BufferAttribute(new Uint32Array([0, 1, 2, 2, 1, 3]), 1));
    geometry.setAttribute('ends', new InstancedBufferAttribute(ends, 2));
    geometry.setAttribute('tint', new InstancedBufferAttribute(tints, 3));
    geometry.instanceCount = ends.length / 2;
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: EDGE_VERTEX,
      fragmentShader: EDGE_FRAGMENT,
      uniforms: {
        positions: { value: null },
        viewport: { value: new Vector2(1, 1) },
        width: { value: style.width },
        opacity: { value: style.opacity },
        lift: { value: style.lift },
        fade: { value: style.fade },
        shade: { value: new Vector3(1, 1, 1) },
      },
      transparent: true,
      depthWrite: false,
      side: DoubleSide,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
  }

  /** What the lines follow, in which colour, and the pixels of the picture they are drawn into. */
  set(positions: Texture, shade: Colour, width: number, height: number, ratio: number): void {
    const { uniforms } = this.mesh.material;
    uniforms['positions']!.value = positions;
    uniforms['shade']!.value.set(...shade);
    uniforms['viewport']!.value.set(width, height);
    uniforms['width']!.value = this.style.width * ratio;
    uniforms['fade']!.value = this.style.fade * ratio;
    this.mesh.material.uniformsNeedUpdate = true;
  }

  get bytes(): number {
    return 20 * this.mesh.geometry.instanceCount;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

/** Edges of the polygons of all parts that are shown. */
export function wireframe(model: Model): Edges {
  const shown = new Uint8Array(model.neutral.length / 3);
  for (const part of model.parts) {
    if (!part.shown) continue;
    for (let i = part.start; i < part.start + part.count; i += 1)
      shown[model.seams[model.triangles[i]!]!] = 1;
  }
  const ends = new Uint32Array(model.edges.length);
  let length = 0;
  for (let i = 0; i < ends.length; i += 2) {
    if (!shown[model.seams[model.edges[i]!]!]) continue;
    ends[length] = model.edges[i]!;
    ends[length + 1] = model.edges[i + 1]!;
    length += 2;
  }
  const style = { width: 0.9, opacity: 0.42, lift: 0.0006, fade: 7 };
  return new Edges(ends.slice(0, length), tintsOn(model, ends.subarray(0, length)), style);
}

/** White, which the shade of the lines darkens; so bright that it stays light on what is dark. */
function tintsOn(model: Model, ends: Uint32Array): Float32Array {
  const dark = darkVertices(model);
  return Float32Array.from({ length: (3 * ends.length) / 2 }, (_, i) =>
    dark[ends[2 * Math.floor(i / 3)]!] ? LIGHT : 1,
  );
}

/** Loops, each in its colour. */
export function loopLines(model: Model): Edges {
  const count = model.neutral.length / 3;
  const ends: number[] = [];
  const tints: number[] = [];
  model.loops.forEach(({ vertices, closed }, number) => {
    const colour = new Color()
      .setStyle(loopColours[number % loopColours.length]!)
      .getRGB({ r: 0, g: 0, b: 0 }, SRGBColorSpace);
    for (let i = closed ? 0 : 1; i < vertices.length; i += 1) {
      const [from, to] = [vertices.at(i - 1)!, vertices[i]!];
      if (from >= count || to >= count) continue;
      ends.push(from, to);
      tints.push(colour.r, colour.g, colour.b);
    }
  });
  return new Edges(Uint32Array.from(ends), Float32Array.from(tints), {
    width: 2.6,
    opacity: 1,
    lift: 0.0015,
    fade: 0,
  });
}
