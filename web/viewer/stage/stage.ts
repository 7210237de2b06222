// The stage: draws faces as a state says, when something has changed.
import { Vector3 } from 'three';
import { driveOf, type Drive } from '../rig/pose';
import { clipNamed } from '../rig/clips';
import { headOf } from '../rig/head';
import type { Head, Model } from '../types/model';
import type { Pick, Place, Position, Readout, Spot, Stage, View } from '../types/stage';
import type { ViewState } from '../types/state';
import { FaceCamera } from './camera';
import { Comparison } from './comparison';
import type { Face } from './face';
import { Pace } from './pace';
import { Painter } from './painter';
import { pickVertex } from './picking';
import { portrait } from './portrait';
import { inArea, viewportsOf, within, type Area, type Viewport } from './viewports';

type Colour = readonly [number, number, number];

const AT_REST = 180; // milliseconds without another pose until the picture is drawn at its best
const NAMES = 36; // CSS pixels above each of the faces side by side

/** @throws Error where the browser has no WebGL 2 */
export function createStage(container: HTMLElement): Stage {
  return new FaceStage(container);
}

class FaceStage implements Stage {
  private readonly painter: Painter;
  private readonly view: FaceCamera;
  private readonly comparison = new Comparison();
  private readonly pace = new Pace();
  private readonly resized: ResizeObserver;
  private faces: Face[] = [];
  private state: ViewState | null = null;
  private dark = matchMedia('(prefers-color-scheme: dark)').matches;
  private waiting = 0;
  private moving = false;
  private settling: ReturnType<typeof setTimeout> | undefined;
  private looking: View | null = 'front';
  private head: Head | null = null; // of a phone
  private readonly listeners: (() => void)[] = [];

  constructor(private readonly container: HTMLElement) {
    this.painter = new Painter();
    const { canvas } = this.painter;
    canvas.style.cssText =
      'display: block; width: 100%; height: 100%; touch-action: none; outline: none';
    container.append(canvas);
    this.view = new FaceCamera(canvas, () => {
      this.looking = null;
      this.moving = true;
      this.request();
    });
    this.resized = new ResizeObserver(() => this.resize());
    this.resized.observe(container);
    canvas.addEventListener('webglcontextrestored', () => {
      this.painter.restore();
      this.faces.forEach((face) => face.forget());
      this.request();
    });
    this.resize();
  }

  setModels(models: readonly Model[]): void {
    const made: Face[] = [];
    try {
      for (const model of models) made.push(this.painter.face(model));
    } catch (error) {
      made.forEach((face) => face.dispose());
      throw error;
    }
    const alike = this.faces[0]?.model.neutral.length === models[0]?.neutral.length;
    this.faces.forEach((face) => face.dispose());
    this.faces = made;
    this.comparison.forget();
    this.painter.forget();
    if (models[0]) {
      this.view.frame(models[0]);
      if (!alike || this.looking) this.look(this.looking ?? 'front');
    }
    this.request();
  }

  show(state: ViewState): void {
    const arranged =
      this.state?.arrangement !== state.arrangement ||
      this.state.shown.length !== state.shown.length;
    if (this.state && !samePose(this.state, state)) this.moving = true;
    this.state = state;
    if (arranged && this.looking) this.look(this.looking);
    this.request();
  }

  turnHead(head: Head): void {
    this.head = head;
  }

  flush(atRest = true): void {
    if (atRest) this.moving = false;
    this.present();
  }

  private present(): void {
    cancelAnimationFrame(this.waiting);
    this.waiting = 0;
    this.draw();
    clearTimeout(this.settling);
    if (this.moving) this.settling = setTimeout(() => this.rest(), AT_REST);
    for (const listener of this.listeners) listener();
  }

  drawn(listener: () => void): void {
    this.listeners.push(listener);
  }

  positions(model: number): Float32Array {
    const face = this.faces[model];
    if (!face) throw new Error(`There is no model ${model}; there are ${this.faces.length}.`);
    if (this.state) face.show(this.drive(this.state));
    return face.positions().slice();
  }

  pick(x: number, y: number): Pick | null {
    const { state } = this;
    if (!state) return null;
    const up = this.height - y;
    const viewport = this.viewports(state).find(({ cut }) => within(cut, x, up));
    const face = viewport && this.faces[viewport.model];
    if (!viewport || !face) return null;
    const { area } = viewport;
    this.view.shape(area.width / area.height);
    const at = inArea(area, x, up);
    face.show(this.drive(state));
    const positions = face.positions();
    const vertex = pickVertex(face.model, positions, this.view.camera, at);
    if (vertex === null) return null;
    const place = (of: Float32Array) =>
      [of[3 * vertex]!, of[3 * vertex + 1]!, of[3 * vertex + 2]!] as const;
    const position = place(positions);
    return {
      model: viewport.model,
      vertex,
      position,
      distance: this.distanceAt(viewport.model, state, position, place),
    };
  }

  spot(model: number, position: ArrayLike<number>): Spot | null {
    const viewport = this.viewportOf(model);
    if (!viewport) return null;
    const { area, cut } = viewport;
    const seen = this.seen(area, position);
    const x = area.x + (0.5 + 0.5 * seen.x) * area.width;
    const up = area.y + (0.5 + 0.5 * seen.y) * area.height;
    return { x, y: this.height - up, drawn: Math.abs(seen.z) <= 1 && within(cut, x, up) };
  }

  across(model: number, position: ArrayLike<number>, x: number, y: number): Position {
    const area = this.viewportOf(model)?.area ?? this.whole;
    // Points of such a plane have one depth.
    const { z } = this.seen(area, position);
    const at = new Vector3(...inArea(area, x, this.height - y), z).unproject(this.view.camera);
    return [at.x, at.y, at.z];
  }

  eye(): Position {
    const { x, y, z } = this.view.camera.position;
    return [x, y, z];
  }

  readout(): Readout {
    const { state } = this;
    const shown = state ? [...new Set(this.viewports(state).map(({ model }) => model))] : [];
    const bytes = this.faces.reduce((sum, face) => sum + face.bytes, this.painter.bytes);
    return {
      frameMilliseconds: this.pace.milliseconds,
      framesPerSecond: this.pace.framesPerSecond,
      targets: shown.reduce((sum, model) => sum + (this.faces[model]?.targets ?? 0), 0),
      mebibytes: bytes / 2 ** 20,
      gpu: this.faces.every((face) => face.poser.gpu),
      heat: state && this.comparison.of(this.faces, shown, state),
    };
  }

  look(view: View): void {
    this.view.look(view, this.aspect, this.above);
    this.looking = view;
    this.moving = false;
    this.request();
  }

  camera(): View | Place {
    return this.looking ?? this.view.place;
  }

  goTo(place: Place): void {
    this.view.place = place;
    this.looking = null;
    this.request();
  }

  portrait(weights: ViewState['weights']): HTMLCanvasElement {
    const { painter, view, faces, state, dark, looking } = this;
    const made = portrait(painter, view, faces, state!, weights, dark);
    this.looking = looking;
    this.draw();
    return made;
  }

  turn(azimuth: number, elevation: number): void {
    this.view.turn(azimuth, elevation);
    this.looking = null;
    this.request();
  }

  zoom(factor: number): void {
    this.view.zoom(factor);
    this.looking = null;
    this.request();
  }

  setDark(dark: boolean): void {
    this.dark = dark;
    this.request();
  }

  dispose(): void {
    cancelAnimationFrame(this.waiting);
    clearTimeout(this.settling);
    this.resized.disconnect();
    this.faces.forEach((face) => face.dispose());
    this.faces = [];
    this.view.dispose();
    this.painter.dispose();
  }

  private get width(): number {
    return Math.max(1, this.container.clientWidth);
  }

  private get height(): number {
    return Math.max(1, this.container.clientHeight);
  }

  /** Of the narrowest viewport, which must hold the face. */
  private get aspect(): number {
    const areas = this.state ? this.viewports(this.state).map(({ area }) => area) : [];
    return Math.min(...areas.map(({ width, height }) => width / height), this.width / this.height);
  }

  /** Share of the height that names of models need above the faces. */
  private get above(): number {
    const named = this.state?.arrangement === 'side' && this.faces.length > 1;
    return named ? Math.min(NAMES / this.height, 0.2) : 0;
  }

  private viewports(state: ViewState): Viewport[] {
    return viewportsOf(state, this.faces.length, this.width, this.height);
  }

  private viewportOf(model: number): Viewport | undefined {
    return this.state ? this.viewports(this.state).find((one) => one.model === model) : undefined;
  }

  private get whole(): Area {
    return { x: 0, y: 0, width: this.width, height: this.height };
  }

  /** A point as an area shows it: −1 to 1 rightwards, upwards and into the picture. */
  private seen(area: Area, position: ArrayLike<number>): Vector3 {
    this.view.shape(area.width / area.height);
    return new Vector3().fromArray(Array.from(position)).project(this.view.camera);
  }

  private drive(state: ViewState): Drive {
    return driveOf(
      this.faces.map(({ model }) => model),
      state,
    );
  }

  private headNow(state: ViewState): Head | null {
    if (!state.headTurns) return null;
    const clip = clipNamed(
      this.faces.map(({ model }) => model),
      state,
    );
    if (clip) return headOf(clip, state.clipTime);
    return state.live ? this.head : null;
  }

  private request(): void {
    if (!this.waiting) this.waiting = requestAnimationFrame(() => this.present());
  }

  private rest(): void {
    this.moving = false;
    this.request();
  }

  private resize(): void {
    this.painter.resize(this.width, this.height);
    if (this.looking && this.faces.length > 0) this.look(this.looking);
    // A canvas of a new size is empty until it is drawn; drawn later it would flicker.
    if (this.faces.length > 0) this.flush();
  }

  private draw(): void {
    const start = performance.now();
    const { state, looking, painter } = this;
    const moving = this.view.update();
    if (!moving) this.looking = looking;
    if (!state || this.faces.length === 0) {
      painter.clear(this.dark);
      return;
    }
    this.view.head = this.headNow(state);
    const drive = this.drive(state);
    const viewports = this.viewports(state);
    const shown = [...new Set(viewports.map(({ model }) => model))];
    const needed = state.heat ? [...shown, state.against] : shown;
    for (const number of new Set(needed)) this.faces[number]?.show(drive);
    const heat = this.comparison.of(this.faces, shown, state);
    const look = { state, drive, dark: this.dark, heatTop: heat?.top ?? 1, moving: this.moving };
    painter.draw(this.faces, viewports, this.view, look);
    this.pace.add(start, performance.now() - start);
    if (moving) this.request();
  }

  private distanceAt(
    model: number,
    state: ViewState,
    position: Colour,
    place: (of: Float32Array) => Colour,
  ): number | null {
    const against = this.faces[state.against];
    if (!state.heat || !against || model === state.against) return null;
    against.show(this.drive(state));
    const other = place(against.positions());
    return Math.hypot(position[0] - other[0], position[1] - other[1], position[2] - other[2]);
  }
}

function samePose(one: ViewState, other: ViewState): boolean {
  return one.weights === other.weights && one.t === other.t;
}
