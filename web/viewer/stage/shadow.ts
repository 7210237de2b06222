// The map of what the key light reaches of a face, drawn anew for each picture.
import {
  DepthTexture,
  DoubleSide,
  GLSL3,
  LessEqualCompare,
  LinearFilter,
  type Matrix4,
  Mesh,
  RawShaderMaterial,
  Scene,
  UnsignedIntType,
  Vector3,
  Vector4,
  WebGLRenderTarget,
  type BufferGeometry,
  type PerspectiveCamera,
  type WebGLRenderer,
} from 'three';
import type { Shape } from './shape';
import { LIGHT_SPACE, SHADOW_FRAGMENT } from './shaders/shadow';
import { VERTEX_FETCH } from './shaders/vertices';

const SIZE = 1024;
const [FEWEST, MOST] = [2, 8]; // looks a pixel: soft edges wait until nothing moves
const KEPT = 400; // milliseconds for which a moving face may have the shadow of an earlier pose

const SHADOW_VERTEX = /* glsl */ `
${VERTEX_FETCH}
${LIGHT_SPACE}
in uvec2 corner;
uniform mat4 modelViewMatrix;
uniform sampler2D positions;
void main() {
  vec3 at = inLight((modelViewMatrix * vec4(ofVertex(positions, corner.x).xyz, 1.0)).xyz);
  gl_Position = vec4(at.xy, -at.z, 1.0);
}
`;

export class Shadow {
  readonly map: DepthTexture;
  /** Middle of the face in the camera's space, and its radius. */
  readonly ball = new Vector4(0, 0, 0, 1);
  /** How often a pixel looks into the map, as a uniform. */
  readonly looks = { value: MOST };
  private last: { at: number; shape: Shape; from: Matrix4 } | null = null;
  private readonly target: WebGLRenderTarget;
  private readonly material: RawShaderMaterial;
  private readonly scene = new Scene();
  private readonly mesh: Mesh<BufferGeometry, RawShaderMaterial>;

  constructor(renderer: WebGLRenderer) {
    this.map = new DepthTexture(SIZE, SIZE, UnsignedIntType);
    this.map.compareFunction = LessEqualCompare;
    this.map.minFilter = LinearFilter;
    this.map.magFilter = LinearFilter;
    this.target = new WebGLRenderTarget(SIZE, SIZE, { depthTexture: this.map });
    // What draws faces reads the map even where no light has cast a shadow yet.
    renderer.initRenderTarget(this.target);
    this.material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: SHADOW_VERTEX,
      fragmentShader: SHADOW_FRAGMENT,
      uniforms: { positions: { value: null }, ball: { value: this.ball } },
      side: DoubleSide,
      colorWrite: false,
    });
    this.mesh = new Mesh<BufferGeometry, RawShaderMaterial>(undefined, this.material);
    this.mesh.frustumCulled = false;
    this.scene.add(this.mesh);
  }

  /**
   * @param moving keeps the shadow of an earlier pose for a while, where the same face is seen from
   *   where it was.
   */
  draw(
    renderer: WebGLRenderer,
    camera: PerspectiveCamera,
    geometry: BufferGeometry,
    shape: Shape,
    middle: Vector3,
    radius: number,
    moving: boolean,
  ): void {
    this.looks.value = moving ? FEWEST : MOST;
    const [from, at] = [camera.matrixWorldInverse, performance.now()];
    const { last } = this;
    if (moving && last?.shape === shape && last.from.equals(from) && at - last.at < KEPT) return;
    this.last = { at, shape, from: from.clone() };
    const seen = middle.clone().applyMatrix4(camera.matrixWorldInverse);
    this.ball.set(seen.x, seen.y, seen.z, radius);
    this.mesh.geometry = geometry;
    this.material.uniforms['positions']!.value = shape.positions;
    this.material.uniformsNeedUpdate = true;
    renderer.setRenderTarget(this.target);
    renderer.clear(true, true, false);
    renderer.render(this.scene, camera);
    renderer.setRenderTarget(null);
  }

  get bytes(): number {
    return 8 * SIZE * SIZE;
  }

  dispose(): void {
    this.target.dispose();
    this.map.dispose();
    this.material.dispose();
  }
}
