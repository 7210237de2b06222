// Draws posed faces: what is seen in each viewport, and in which light.
import { Camera, Scene as Space, WebGLRenderer } from 'three';
import type { Drive } from '../rig/pose';
import type { Model } from '../types/model';
import type { ViewState } from '../types/state';
import { Backdrop } from './backdrop';
import type { FaceCamera } from './camera';
import type { Edges } from './edges';
import { Face, type GhostLook } from './face';
import { clayMatcap } from './matcap';
import { Orbits } from './orbits';
import { Shadow } from './shadow';
import { heatTexture, type Pictures } from './skin';
import { SoftEdges } from './soft_edges';
import type { Area, Viewport } from './viewports';

type Colour = readonly [number, number, number];

/** How faces that are posed already are drawn. */
export interface Look {
  readonly state: ViewState;
  readonly drive: Drive;
  readonly dark: boolean;
  readonly heatTop: number; // distance of the last colour
  readonly moving: boolean; // what only a picture at rest needs may wait
}

const SHARPEST = 2; // pixels a CSS pixel; more cost time and show nothing
const MOST_ONION = 9;
const NOWHERE = new Camera(); // the wall covers the picture wherever it is seen from

export class Painter {
  readonly canvas: HTMLCanvasElement;
  private readonly renderer = rendererOr();
  private readonly softEdges = new SoftEdges(this.renderer);
  private readonly wall = new Space();
  private readonly space = new Space();
  private readonly backdrop = new Backdrop();
  private readonly orbits = new Orbits();
  private readonly pictures: Pictures = {
    heat: heatTexture(),
    matcap: clayMatcap(),
    shadow: new Shadow(this.renderer),
  };
  private width = 1;
  private height = 1;

  /** @throws Error where the browser has no WebGL 2 */
  constructor() {
    this.canvas = this.renderer.domElement;
    this.wall.add(this.backdrop.mesh);
    this.space.add(this.orbits.group);
  }

  /** @throws Error where the graphics card has no room for a model */
  face(model: Model): Face {
    const face = new Face(this.renderer, model, this.pictures);
    this.space.add(face.group);
    return face;
  }

  /** The context is there again, empty. */
  restore(): void {
    this.softEdges.forget();
  }

  /** The models are others now. */
  forget(): void {
    this.orbits.clear();
  }

  /** The canvas is so many CSS pixels large. */
  resize(width: number, height: number): void {
    [this.width, this.height] = [width, height];
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, SHARPEST));
    this.renderer.setSize(width, height, false);
  }

  draw(faces: readonly Face[], viewports: readonly Viewport[], view: FaceCamera, look: Look): void {
    const shown = [...new Set(viewports.map(({ model }) => model))];
    const { state, drive, dark } = look;
    for (const number of shown) dress(faces[number]!, faces[state.against], look);
    if (state.orbits) {
      const models = faces.map(({ model }) => model);
      this.orbits.show(models, shown, drive, state.picked, dark);
    } else this.orbits.clear();
    this.renderer.setScissorTest(true);
    for (const viewport of viewports) {
      faces.forEach((face, number) => (face.group.visible = number === viewport.model));
      this.drawViewport(faces[viewport.model]!, viewport, view, look);
    }
    if (!look.moving) this.softEdges.show();
  }

  /** Draws the wall alone. */
  clear(dark: boolean): void {
    this.renderer.setScissorTest(false);
    this.paintWall({ x: 0, y: 0, width: this.width, height: this.height }, dark);
  }

  /** Pixels of the canvas to a CSS pixel. */
  get ratio(): number {
    return this.renderer.getPixelRatio();
  }

  /** Bytes on the graphics card, without those of faces. */
  get bytes(): number {
    return this.pictures.shadow.bytes + this.softEdges.bytes;
  }

  dispose(): void {
    const { heat, matcap, shadow } = this.pictures;
    this.orbits.clear();
    const { softEdges, backdrop, renderer } = this;
    for (const owned of [softEdges, backdrop, heat, matcap, shadow, renderer]) owned.dispose();
    this.canvas.remove();
  }

  private drawViewport(face: Face, { area, cut }: Viewport, view: FaceCamera, look: Look): void {
    const { renderer } = this;
    this.drawLines(face, area, look);
    view.shape(area.width / area.height);
    const { camera, middle, size } = view;
    if (look.state.light === 'studio') {
      const { casting, shape } = face;
      const { shadow } = this.pictures;
      shadow.draw(renderer, camera, casting, shape, middle, 0.6 * size, look.moving);
    }
    face.arrange(camera);
    renderer.setScissor(cut.x, cut.y, cut.width, cut.height);
    if (!look.moving) this.softEdges.take();
    this.paintWall(area, look.dark);
    renderer.render(this.space, camera);
  }

  /** Turns to an area of the canvas and paints the wall there. */
  private paintWall(area: Area, dark: boolean): void {
    const { renderer, backdrop } = this;
    const ratio = renderer.getPixelRatio();
    renderer.setViewport(area.x, area.y, area.width, area.height);
    renderer.clear(true, true, false);
    backdrop.set(dark, area.x * ratio, area.y * ratio, area.width * ratio, area.height * ratio);
    renderer.render(this.wall, NOWHERE);
  }

  private drawLines(face: Face, area: Area, { state }: Look): void {
    const ratio = this.renderer.getPixelRatio();
    const draw = (edges: Edges, colour: Colour) => {
      edges.mesh.visible = true;
      edges.set(face.shape.positions, colour, area.width * ratio, area.height * ratio, ratio);
    };
    face.hideLines();
    if (state.wireframe) draw(face.wireframe(), [0.1, 0.09, 0.09]);
    if (state.loops && face.model.loops.length > 0) draw(face.loopLines(), [1, 1, 1]);
  }
}

/** What a face is drawn with besides its pose. */
function dress(face: Face, against: Face | undefined, { state, drive, dark, heatTop }: Look): void {
  const measured = state.heat && against !== undefined && against !== face;
  face.tell({
    measuring: measured,
    heatTop,
    against: (measured ? against : face).shape.positions,
    inMatcap: state.light === 'matcap',
    flatShading: state.shading === 'flat',
  });
  face.showGhosts(ghostsOf(state, drive, dark));
}

/** The neutral and the in-betweens that a state asks for. */
function ghostsOf(state: ViewState, drive: Drive, dark: boolean): GhostLook[] {
  const neutral: Colour = dark ? [0.62, 0.78, 1] : [0.22, 0.42, 0.72];
  const ghosts = state.ghost ? [{ drive: { ...drive, t: 0 }, tint: neutral, opacity: 0.45 }] : [];
  const count = Math.min(Math.max(Math.round(state.onion), 0), MOST_ONION);
  for (let i = 1; i <= count; i += 1) {
    const t = i / (count + 1);
    ghosts.push({ drive: { ...drive, t }, tint: onionTint(t), opacity: 0.55 });
  }
  return ghosts;
}

/** From the blue of the neutral to the orange of the end. */
function onionTint(share: number): Colour {
  return [0.3 + 0.62 * share, 0.55 + 0.03 * share, 0.9 - 0.62 * share];
}

function rendererOr(): WebGLRenderer {
  try {
    const renderer = new WebGLRenderer({ powerPreference: 'high-performance' });
    renderer.autoClear = false;
    return renderer;
  } catch {
    throw new Error(
      'This browser cannot draw in 3D: it has no WebGL 2. Turn on hardware acceleration in its ' +
        'settings, or open the page in a recent Chrome, Edge, Firefox or Safari.',
    );
  }
}
