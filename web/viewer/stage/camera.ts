// Where the face is seen from, and how it fills the picture.
import { PerspectiveCamera, Spherical, Vector3 } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { framedBox } from '../rig/framed';
import { headRotation } from '../rig/head';
import type { Head, Model } from '../types/model';
import type { Place, View } from '../types/stage';

const FIELD = 24; // degrees, as a lens of about 85 mm sees
const MARGIN = 1.045;

/** Turn to the right and upwards, in degrees. */
const VIEWS: Readonly<Record<View, readonly [number, number]>> = {
  front: [0, 0],
  'three-quarter': [35, 7],
  side: [90, 0],
  below: [0, -38],
};

export class FaceCamera {
  /** What is drawn with. */
  readonly camera = new PerspectiveCamera(FIELD, 1, 0.1, 100);
  /** The light goes with the camera, so a head that turns is one that is seen from elsewhere. */
  head: Head | null = null;
  /** Where people have put it: before a head that is turned. */
  private readonly held = this.camera.clone();
  private readonly controls: OrbitControls;
  private corners: Vector3[] = [new Vector3()];
  /** Middle of the box round the face, and its diagonal. */
  readonly middle = new Vector3();
  private readonly neck = new Vector3(); // which the head turns about
  size = 1;
  private reaches = 1;

  /** @param changed called when somebody has moved the camera */
  constructor(canvas: HTMLElement, changed: () => void) {
    this.controls = new OrbitControls(this.held, canvas);
    this.controls.dampingFactor = 0.18;
    this.controls.rotateSpeed = 0.8;
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', changed);
  }

  /** What is to fill the picture: the neutral of a model, as far as it is drawn. */
  frame(model: Model): void {
    const { drawn, framed, low, high, neck } = framedBox(model);
    const at = new Vector3();
    this.corners = boundary(model, framed);
    this.middle.addVectors(low, high).multiplyScalar(0.5);
    this.neck.copy(neck);
    this.size = Math.max(low.distanceTo(high), 1e-9);
    // A body goes on beyond the face, and is seen when somebody moves away.
    this.reaches = this.size;
    drawn.forEach((counts, v) => {
      if (counts)
        this.reaches = Math.max(
          this.reaches,
          at.fromArray(model.neutral, 3 * v).distanceTo(this.middle),
        );
    });
    this.controls.minDistance = 0.15 * this.size;
    this.controls.maxDistance = 12 * this.size;
  }

  /**
   * Looks at the face from a side, as near as it fits.
   *
   * @param aspect width of the picture over its height
   * @param above share of the height that stays free above the face
   */
  look(view: View, aspect: number, above: number): void {
    const [turn, lift] = VIEWS[view].map((degrees) => (degrees * Math.PI) / 180) as [
      number,
      number,
    ];
    const back = new Vector3().setFromSphericalCoords(1, Math.PI / 2 - lift, turn);
    this.fit(back, aspect, above);
  }

  get place(): Place {
    const { target } = this.controls;
    const { theta, phi, radius } = new Spherical().setFromVector3(
      this.held.position.clone().sub(target),
    );
    const aim = target.clone().sub(this.middle).divideScalar(this.size);
    const degrees = 180 / Math.PI;
    return [theta * degrees, 90 - phi * degrees, radius / this.size, ...aim.toArray()];
  }

  set place([turn, lift, distance, ...aim]: Place) {
    const { target } = this.controls;
    const radians = Math.PI / 180;
    target.fromArray(aim).multiplyScalar(this.size).add(this.middle);
    const back = new Vector3().setFromSphericalCoords(
      distance * this.size,
      (90 - lift) * radians,
      turn * radians,
    );
    this.held.position.copy(target).add(back);
    this.controls.update();
  }

  turn(azimuth: number, elevation: number): void {
    const target = this.controls.target;
    const offset = this.held.position.clone().sub(target);
    const place = new Spherical().setFromVector3(offset);
    place.theta += azimuth;
    place.phi = Math.min(Math.max(place.phi - elevation, 0.02), Math.PI - 0.02);
    this.held.position.setFromSpherical(place).add(target);
    this.controls.update();
  }

  zoom(factor: number): void {
    if (!(factor > 0)) return;
    const target = this.controls.target;
    const distance = this.held.position.distanceTo(target) / factor;
    const { minDistance, maxDistance } = this.controls;
    const offset = this.held.position.clone().sub(target);
    this.held.position
      .copy(target)
      .add(offset.setLength(Math.min(Math.max(distance, minDistance), maxDistance)));
    this.controls.update();
  }

  /** Moves on what somebody has set going; whether it has not come to rest. */
  update(): boolean {
    this.controls.enableDamping = !matchMedia('(prefers-reduced-motion: reduce)').matches;
    return this.controls.update();
  }

  /** The picture is of this aspect now. */
  shape(aspect: number): void {
    const { held, camera, head, neck } = this;
    const distance = held.position.distanceTo(this.middle);
    held.near = Math.max(distance - 1.5 * this.reaches, 0.01 * this.size);
    held.far = distance + 1.5 * this.reaches;
    held.aspect = aspect;
    held.updateProjectionMatrix();
    held.updateMatrixWorld();
    camera.copy(held);
    if (head) {
      const back = headRotation(head).invert();
      camera.position.sub(neck).applyQuaternion(back).add(neck);
      camera.quaternion.premultiply(back);
    }
    camera.updateMatrixWorld();
  }

  dispose(): void {
    this.controls.dispose();
  }

  private fit(back: Vector3, aspect: number, above: number): void {
    const right = new Vector3(0, 1, 0).cross(back).normalize();
    const up = back.clone().cross(right);
    const tall = Math.tan((FIELD * Math.PI) / 360) / MARGIN;
    const wide = tall * aspect;
    const across = this.reach(right, back, wide, wide);
    const high = this.reach(up, back, tall * (1 - 2 * above), tall);
    const distance = Math.max(across.distance, high.distance);
    const eye = back.clone().multiplyScalar(distance);
    eye.addScaledVector(right, across.middle(distance)).addScaledVector(up, high.middle(distance));
    this.controls.target.copy(eye).addScaledVector(back, this.middle.dot(back) - distance);
    this.held.position.copy(eye);
    this.controls.update();
  }

  /**
   * How far away the eye must be for all points to lie between two opposite planes of the picture,
   * which open with these slopes, and where it must then be along the axis.
   */
  private reach(axis: Vector3, back: Vector3, ahead: number, behind: number) {
    let [most, least] = [-Infinity, -Infinity];
    for (const corner of this.corners) {
      const [aside, near] = [corner.dot(axis), corner.dot(back)];
      most = Math.max(most, aside + ahead * near);
      least = Math.max(least, behind * near - aside);
    }
    return {
      distance: (most + least) / (ahead + behind),
      middle: (distance: number) => (most - least + (behind - ahead) * distance) / 2,
    };
  }
}

/**
 * Points that all others lie between: the vertices of the drawn parts that are farthest in some
 * direction, at rest and at the end of each path, so that an open jaw is seen too.
 */
function boundary(model: Model, drawn: Uint8Array): Vector3[] {
  const directions = spread(162);
  const best = directions.map(() => ({ reach: -Infinity, vertex: 0 }));
  for (let v = 0; v < drawn.length; v += 1) {
    if (!drawn[v]) continue;
    const [x, y, z] = [model.neutral[3 * v]!, model.neutral[3 * v + 1]!, model.neutral[3 * v + 2]!];
    for (let i = 0; i < directions.length; i += 1) {
      const [a, b, c] = directions[i]!;
      const reach = a * x + b * y + c * z;
      if (reach > best[i]!.reach) best[i] = { reach, vertex: v };
    }
  }
  return [...new Set(best.map(({ vertex }) => vertex))].flatMap((vertex) => {
    const rest = new Vector3().fromArray(model.neutral, 3 * vertex);
    const ends = model.morphs.map(({ delta }) =>
      new Vector3().fromArray(model.targets[delta]!, 3 * vertex).add(rest),
    );
    return [rest, ...ends];
  });
}

/** Directions evenly over the sphere, along a spiral. */
function spread(count: number): (readonly [number, number, number])[] {
  const turn = Math.PI * (3 - Math.sqrt(5));
  return Array.from({ length: count }, (_, i) => {
    const y = 1 - (2 * i + 1) / count;
    const round = Math.sqrt(1 - y * y);
    return [round * Math.cos(turn * i), y, round * Math.sin(turn * i)] as const;
  });
}
