// One model on the stage: its shapes on the graphics card and what is drawn of them.
import {
  Group,
  Mesh,
  Vector3,
  type BufferGeometry,
  type Camera,
  type DataTexture,
  type RawShaderMaterial,
  type WebGLRenderer,
} from 'three';
import { activeTargets, type ActiveTarget, type Drive } from '../rig/pose';
import type { Model } from '../types/model';
import { CpuPoser } from './cpu_poser';
import { loopLines, wireframe, type Edges } from './edges';
import { imageBytes, texturesIn } from './dress';
import { canDrawFloats, GpuPoser } from './gpu_poser';
import { passesOf, Sorting } from './passes';
import type { Poser, Shape } from './shape';
import {
  castingGeometry,
  ghostMaterial,
  partTexture,
  skinGeometry,
  skinMaterials,
  type Pictures,
} from './skin';

/** A shape, and the morph targets it was last posed with. */
interface Posed {
  readonly shape: Shape;
  key: string | null;
}

interface Ghost {
  readonly posed: Posed;
  readonly depth: Mesh<BufferGeometry, RawShaderMaterial>;
  readonly colour: Mesh<BufferGeometry, RawShaderMaterial>;
}

/** A translucent face: its pose and its colour. */
export interface GhostLook {
  readonly drive: Drive;
  readonly tint: readonly [number, number, number];
  readonly opacity: number;
}

export class Face {
  readonly group = new Group();
  readonly skin: Mesh<BufferGeometry, RawShaderMaterial | RawShaderMaterial[]>;
  /** Of the parts; they share what they are told of pose and light. */
  readonly materials: readonly RawShaderMaterial[];
  /** What casts a shadow. */
  readonly casting: BufferGeometry;
  readonly poser: Poser;
  private readonly parts: DataTexture;
  private readonly sorting: Sorting;
  private readonly now: Posed;
  private readonly rest: Posed;
  private readonly ghosts: Ghost[] = [];
  private wires: Edges | null = null;
  private loops: Edges | null = null;
  private held: { key: string | null; positions: Float32Array } | null = null;
  private activeCount = 0;

  constructor(
    renderer: WebGLRenderer,
    readonly model: Model,
    pictures: Pictures,
  ) {
    this.poser = canDrawFloats(renderer) ? new GpuPoser(renderer, model) : new CpuPoser(model);
    this.parts = partTexture(model);
    const passes = passesOf(model.parts);
    const materials = skinMaterials(model, passes, this.parts, pictures);
    const geometry = skinGeometry(model, passes);
    this.sorting = new Sorting(geometry, model, passes);
    this.materials = materials;
    this.casting = castingGeometry(geometry, model);
    this.skin = new Mesh(geometry, geometry.groups.length > 0 ? materials : materials[0]!);
    this.skin.frustumCulled = false;
    this.tell({ painting: model.parts.some(({ eye }) => eye) });
    this.group.add(this.skin);
    this.now = { shape: this.poser.shape(), key: null };
    this.rest = { shape: this.poser.shape(), key: null };
    this.pose(this.rest, []);
  }

  /** Poses the face; nothing is done where it has this pose already. */
  show(drive: Drive): void {
    const active = activeTargets(this.model, drive);
    this.activeCount = active.length;
    this.pose(this.now, active);
    const { positions, normals } = this.shape;
    const { positions: rest, normals: restNormals } = this.rest.shape;
    this.tell({ rest, restNormals, positions, normals });
  }

  /** Tells what draws the face the values of some uniforms. */
  tell(values: Readonly<Record<string, unknown>>): void {
    for (const material of this.materials) {
      for (const [name, value] of Object.entries(values)) material.uniforms[name]!.value = value;
      material.uniformsNeedUpdate = true;
    }
  }

  /** What blends is drawn from far to near as this camera sees it. */
  arrange({ matrixWorldInverse }: Camera): void {
    this.sorting.sort(matrixWorldInverse);
  }

  get shape(): Shape {
    return this.now.shape;
  }

  /** Morph targets that move something in the pose. */
  get targets(): number {
    return this.activeCount;
  }

  /** What tells this pose from others. */
  get key(): string {
    return this.now.key ?? '';
  }

  /** (V, 3) positions of the pose, read back once a pose. */
  positions(): Float32Array {
    if (this.held?.key !== this.now.key)
      this.held = { key: this.now.key, positions: this.poser.read(this.now.shape) };
    return this.held!.positions;
  }

  /** Everything on the graphics card may be gone. */
  forget(): void {
    for (const posed of [this.now, this.rest, ...this.ghosts.map((g) => g.posed)]) posed.key = null;
    this.held = null;
    this.pose(this.rest, []);
  }

  wireframe(): Edges {
    return (this.wires ??= this.added(wireframe(this.model), 4));
  }

  loopLines(): Edges {
    return (this.loops ??= this.added(loopLines(this.model), 5));
  }

  hideLines(): void {
    for (const edges of [this.wires, this.loops]) if (edges) edges.mesh.visible = false;
  }

  /** Draws so many translucent faces at the given drives, each in a tint. */
  showGhosts(looks: readonly GhostLook[]): void {
    while (this.ghosts.length < looks.length) this.ghosts.push(this.newGhost(this.ghosts.length));
    this.ghosts.forEach(({ posed, depth, colour }, i) => {
      const wanted = looks[i];
      depth.visible = colour.visible = wanted !== undefined;
      if (!wanted) return;
      this.pose(posed, activeTargets(this.model, wanted.drive));
      for (const { material } of [depth, colour]) {
        const { uniforms } = material;
        uniforms['positions']!.value = posed.shape.positions;
        uniforms['normals']!.value = posed.shape.normals;
        uniforms['rest']!.value = this.rest.shape.positions;
        uniforms['against']!.value = this.shape.positions;
        uniforms['measuring']!.value = true;
        uniforms['apart']!.value = 0.004 * this.model.diameter;
        (uniforms['tint']!.value as Vector3).set(...wanted.tint);
        uniforms['opacity']!.value = wanted.opacity;
        material.uniformsNeedUpdate = true;
      }
    });
  }

  /** Bytes on the graphics card. */
  get bytes(): number {
    const { attributes, index } = this.skin.geometry;
    const images = imageBytes(this.model.parts.map(({ skin }) => skin));
    const arrays = [...Object.values(attributes), index];
    const surface = arrays.reduce((sum, own) => sum + (own?.array.byteLength ?? 0), images);
    const shapes = this.poser.bytesOfShape * (2 + this.ghosts.length);
    return (
      this.poser.bytes + surface + shapes + (this.wires?.bytes ?? 0) + (this.loops?.bytes ?? 0)
    );
  }

  dispose(): void {
    for (const { uniforms } of this.materials) texturesIn(uniforms).forEach((own) => own.dispose());
    for (const { depth, colour, posed } of this.ghosts) {
      depth.material.dispose();
      colour.material.dispose();
      posed.shape.dispose();
    }
    for (const { shape } of [this.now, this.rest]) shape.dispose();
    for (const owned of [
      this.wires,
      this.loops,
      this.parts,
      this.poser,
      this.skin.geometry,
      this.casting,
      ...this.materials,
    ])
      owned?.dispose();
    this.group.removeFromParent();
  }

  private pose(posed: Posed, active: readonly ActiveTarget[]): void {
    const key = active.map(({ target, weight }) => `${target}:${weight}`).join();
    if (key === posed.key) return;
    this.poser.pose(posed.shape, active);
    posed.key = key;
  }

  private newGhost(number: number): Ghost {
    const mesh = (depthOnly: boolean) => {
      const made = new Mesh(this.skin.geometry, ghostMaterial(depthOnly));
      made.frustumCulled = false;
      made.renderOrder = 10 + 2 * number + (depthOnly ? 0 : 1);
      this.group.add(made);
      return made;
    };
    return {
      posed: { shape: this.poser.shape(), key: null },
      depth: mesh(true),
      colour: mesh(false),
    };
  }

  private added(edges: Edges, order: number): Edges {
    edges.mesh.renderOrder = order;
    this.group.add(edges.mesh);
    return edges;
  }
}
