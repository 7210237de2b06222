// Round marks of a size on the screen, with a ring that sets them off from any skin.
import { BufferGeometry, Float32BufferAttribute, GLSL3, Points, RawShaderMaterial } from 'three';

const VERTEX = /* glsl */ `
precision highp float;
in vec3 position;
in float size;
in vec3 tint;
in vec3 ring;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform float ratio;
out vec3 inner;
out vec3 outer;
out float across;
void main() {
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  across = (size + 1.0) * ratio;
  gl_PointSize = across;
  inner = tint;
  outer = ring;
}
`;

const FRAGMENT = /* glsl */ `
precision highp float;
in vec3 inner;
in vec3 outer;
in float across;
out vec4 pixel;
void main() {
  float out1 = across * length(gl_PointCoord - 0.5);
  float whole = clamp(0.5 * across - out1, 0.0, 1.0);
  float core = clamp(0.36 * across - out1 + 0.5, 0.0, 1.0);
  pixel = vec4(mix(outer, inner, core), whole);
}
`;

type Numbers = ArrayLike<number>;

export class Dots {
  private readonly positions: number[] = [];
  private readonly sizes: number[] = [];
  private readonly tints: number[] = [];
  private readonly rings: number[] = [];

  /** One more dot; its size in CSS pixels, colours as screens take them. */
  add(position: Numbers, size: number, tint: Numbers, ring: Numbers): void {
    this.positions.push(...Array.from(position));
    this.sizes.push(size);
    this.tints.push(...Array.from(tint));
    this.rings.push(...Array.from(ring));
  }

  finish(): Points[] {
    if (this.sizes.length === 0) return [];
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new Float32BufferAttribute(this.positions, 3));
    geometry.setAttribute('size', new Float32BufferAttribute(this.sizes, 1));
    geometry.setAttribute('tint', new Float32BufferAttribute(this.tints, 3));
    geometry.setAttribute('ring', new Float32BufferAttribute(this.rings, 3));
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: { ratio: { value: 1 } },
      transparent: true,
      depthTest: false,
      depthWrite: false,
    });
    const points = new Points(geometry, material);
    points.frustumCulled = false;
    points.renderOrder = 50;
    points.onBeforeRender = (renderer) => {
      material.uniforms['ratio']!.value = renderer.getPixelRatio();
      material.uniformsNeedUpdate = true;
    };
    return [points];
  }
}
