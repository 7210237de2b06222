// A calm wall behind the face, lighter where the face is.
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  GLSL3,
  Mesh,
  RawShaderMaterial,
  SRGBColorSpace,
  Vector3,
  Vector4,
} from 'three';
import { BACKDROP_FRAGMENT } from './shaders/backdrop';
import { COVER } from './shaders/pose';

const WALLS = { dark: ['#34373c', '#1b1d20'], light: ['#f7f8f9', '#d9dde1'] } as const;

export class Backdrop {
  readonly mesh: Mesh<BufferGeometry, RawShaderMaterial>;

  constructor() {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(new Float32Array(9), 3));
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: COVER,
      fragmentShader: BACKDROP_FRAGMENT,
      uniforms: {
        middle: { value: new Vector3() },
        edge: { value: new Vector3() },
        area: { value: new Vector4(0, 0, 1, 1) },
      },
      depthTest: false,
      depthWrite: false,
    });
    this.mesh = new Mesh(geometry, material);
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = -1;
  }

  set(dark: boolean, x: number, y: number, width: number, height: number): void {
    const { middle, edge, area } = this.mesh.material.uniforms as Record<string, { value: never }>;
    const [inner, outer] = WALLS[dark ? 'dark' : 'light'];
    (middle!.value as Vector3).fromArray(rgb(inner));
    (edge!.value as Vector3).fromArray(rgb(outer));
    (area!.value as Vector4).set(x, y, width, height);
    this.mesh.material.uniformsNeedUpdate = true;
  }

  dispose(): void {
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
  }
}

function rgb(style: string): number[] {
  const { r, g, b } = new Color().setStyle(style).getRGB({ r: 0, g: 0, b: 0 }, SRGBColorSpace);
  return [r, g, b];
}
