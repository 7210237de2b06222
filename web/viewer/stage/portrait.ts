// A small picture of an expression, drawn in a corner of the canvas that is drawn over afterwards.
import type { ViewState } from '../types/state';
import type { FaceCamera } from './camera';
import type { Face } from './face';
import type { Painter } from './painter';

const PORTRAIT = 112; // pixels
const NEARER = 1.4; // than where the whole head is seen

/** What a portrait shows is the face alone. */
const PLAIN = {
  arrangement: 'single',
  ghost: false,
  onion: 0,
  orbits: false,
  heat: false,
  wireframe: false,
  loops: false,
  shading: 'smooth',
  light: 'studio',
  clip: null,
  t: 1,
} satisfies Partial<ViewState>;

/** From the front, whatever the picture shows and from where. What is drawn last is the portrait. */
export function portrait(
  painter: Painter,
  view: FaceCamera,
  faces: readonly Face[],
  state: ViewState,
  weights: ViewState['weights'],
  dark: boolean,
): HTMLCanvasElement {
  const made = document.createElement('canvas');
  made.width = made.height = PORTRAIT;
  const model = state.shown[0] ?? 0;
  const face = faces[model];
  if (!face) return made;
  const { canvas } = painter;
  const side = Math.min(PORTRAIT, canvas.width, canvas.height);
  const area = { x: 0, y: 0, width: side / painter.ratio, height: side / painter.ratio };
  const drive = { weights, t: 1, off: [] };
  const before = view.place;
  view.head = null;
  view.look('front', 1, 0);
  view.zoom(NEARER);
  face.show(drive);
  const look = { state: { ...state, ...PLAIN, weights }, drive, dark, heatTop: 1, moving: false };
  painter.draw(faces, [{ model, area, cut: area }], view, look);
  const context = made.getContext('2d')!;
  context.drawImage(canvas, 0, canvas.height - side, side, side, 0, 0, PORTRAIT, PORTRAIT);
  view.place = before;
  return made;
}
