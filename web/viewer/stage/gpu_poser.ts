// Poses on the graphics card: a pass for the positions of all vertices and one for their normals.
import {
  BufferGeometry,
  BufferAttribute,
  Camera,
  FloatType,
  GLSL3,
  Mesh,
  NearestFilter,
  NoBlending,
  RawShaderMaterial,
  RGBAFormat,
  Scene,
  WebGLRenderTarget,
  type DataTexture,
  type WebGLRenderer,
} from 'three';
import { oneStretch, shapesInOne, texelsOf, type Texels } from '../rig/layout';
import type { ActiveTarget } from '../rig/pose';
import type { Model } from '../types/model';
import { ringsOf } from './rings';
import { COVER, NORMALS, POSITIONS } from './shaders/pose';
import type { Poser, Shape } from './shape';
import { numberTexture, padded } from './textures';

/** Whether the graphics card can draw into textures of floats. */
export function canDrawFloats(renderer: WebGLRenderer): boolean {
  return renderer.getContext().getExtension('EXT_color_buffer_float') !== null;
}

interface DrawnShape extends Shape {
  readonly targets: readonly [WebGLRenderTarget, WebGLRenderTarget];
}

export class GpuPoser implements Poser {
  readonly gpu = true;
  readonly bytes: number;
  readonly bytesOfShape: number;
  private readonly texels: Texels;
  private readonly textures: readonly DataTexture[];
  private readonly active: DataTexture;
  private readonly positionPass: Pass;
  private readonly normalPass: Pass;

  constructor(
    private readonly renderer: WebGLRenderer,
    private readonly model: Model,
  ) {
    const vertices = model.neutral.length / 3;
    const { width, rows } = (this.texels = texelsOf(vertices));
    this.bytesOfShape = 2 * 16 * width * rows;
    const height = rows * Math.max(1, model.targets.length);
    requireRoom(renderer, model, width, height);
    const neutral = numberTexture(
      padded(model.neutral, width, rows, 'RGB32F'),
      width,
      rows,
      'RGB32F',
    );
    const targets = numberTexture(stretchOf(model), width, height, 'RGB32F');
    const most = Math.max(1, model.targets.length);
    this.active = numberTexture(new Float32Array(2 * most), most, 1, 'RG32F');
    const { ofVertex, corners } = ringsOf(model);
    const rings = numberTexture(padded(ofVertex, width, rows, 'RG32UI'), width, rows, 'RG32UI');
    const across = texelsOf(corners.length / 2);
    const cornerTexture = numberTexture(
      padded(corners, across.width, across.rows, 'RG32UI'),
      across.width,
      across.rows,
      'RG32UI',
    );
    this.textures = [neutral, targets, this.active, rings, cornerTexture];
    this.bytes = this.textures.reduce(
      (sum, { image }) => sum + (image.data as Float32Array).byteLength,
      0,
    );
    this.positionPass = new Pass(POSITIONS, {
      neutral,
      targets,
      moving: this.active,
      movingCount: 0,
    });
    this.normalPass = new Pass(NORMALS, { positions: null, rings, corners: cornerTexture });
  }

  shape(): DrawnShape {
    const { width, rows } = this.texels;
    const target = () =>
      new WebGLRenderTarget(width, rows, {
        format: RGBAFormat,
        type: FloatType,
        internalFormat: 'RGBA32F',
        minFilter: NearestFilter,
        magFilter: NearestFilter,
        depthBuffer: false,
        generateMipmaps: false,
      });
    const targets = [target(), target()] as const;
    return {
      targets,
      positions: targets[0].texture,
      normals: targets[1].texture,
      dispose: () => targets.forEach((t) => t.dispose()),
    };
  }

  pose(shape: Shape, active: readonly ActiveTarget[]): void {
    const [positions, normals] = (shape as DrawnShape).targets;
    const entries = this.active.image.data as Float32Array;
    active.forEach(({ target, weight }, i) => entries.set([target, weight], 2 * i));
    this.active.needsUpdate = true;
    this.positionPass.draw(this.renderer, positions, { movingCount: active.length });
    this.normalPass.draw(this.renderer, normals, { positions: positions.texture });
  }

  read(shape: Shape): Float32Array {
    const { width, rows } = this.texels;
    const four = new Float32Array(4 * width * rows);
    this.renderer.readRenderTargetPixels((shape as DrawnShape).targets[0], 0, 0, width, rows, four);
    const found = new Float32Array(this.model.neutral.length);
    for (let v = 0, from = 0; v < found.length; v += 3, from += 4) {
      found[v] = four[from]!;
      found[v + 1] = four[from + 1]!;
      found[v + 2] = four[from + 2]!;
    }
    return found;
  }

  dispose(): void {
    for (const texture of this.textures) texture.dispose();
    this.positionPass.dispose();
    this.normalPass.dispose();
  }
}

function requireRoom(
  renderer: WebGLRenderer,
  { targets, neutral, name }: Model,
  width: number,
  height: number,
): void {
  const most = renderer.capabilities.maxTextureSize;
  if (height <= most && width <= most) return;
  const count = (n: number) => Math.floor(n).toLocaleString('en');
  const rows = height / Math.max(1, targets.length);
  throw new Error(
    `${name}: ${count(targets.length)} morph targets of ${count(neutral.length / 3)} vertices ` +
      `are too many for this graphics card, which holds ${count(most / rows)} of this size. ` +
      'Export fewer with --only, or with --method linear.',
  );
}

/** All targets in one stretch of memory: that of the file where they lie in one. */
function stretchOf({ targets, neutral }: Model): Float32Array {
  const vertices = neutral.length / 3;
  const { width, rows } = texelsOf(vertices);
  if (targets.length === 0) return new Float32Array(3 * width * rows);
  const whole = oneStretch(targets, vertices);
  if (whole) return whole;
  const copies = shapesInOne(targets.length, vertices);
  targets.forEach((target, i) => copies[i]!.set(target));
  return oneStretch(copies, vertices)!;
}

/** A fragment shader run once for each texel of a render target. */
class Pass {
  private readonly material: RawShaderMaterial;
  private readonly geometry = new BufferGeometry();
  private readonly scene = new Scene();
  private readonly camera = new Camera();

  constructor(fragmentShader: string, values: Record<string, unknown>) {
    this.material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: COVER,
      fragmentShader,
      uniforms: Object.fromEntries(
        Object.entries(values).map(([name, value]) => [name, { value }]),
      ),
      depthTest: false,
      depthWrite: false,
      blending: NoBlending,
    });
    this.geometry.setAttribute('position', new BufferAttribute(new Float32Array(9), 3));
    const mesh = new Mesh(this.geometry, this.material);
    mesh.frustumCulled = false;
    this.scene.add(mesh);
  }

  draw(renderer: WebGLRenderer, target: WebGLRenderTarget, values: Record<string, unknown>): void {
    for (const [name, value] of Object.entries(values)) this.material.uniforms[name]!.value = value;
    this.material.uniformsNeedUpdate = true;
    const before = renderer.getRenderTarget();
    renderer.setRenderTarget(target);
    renderer.render(this.scene, this.camera);
    renderer.setRenderTarget(before);
  }

  dispose(): void {
    this.material.dispose();
    this.geometry.dispose();
  }
}
