// What the pointer does over the face beside turning it: it tells of a vertex, and picks one.
import type { Pick, Stage } from '../../types/stage';
import type { ViewState } from '../../types/state';
import { lengthAndShare } from '../names/lengths';
import { element, setText } from '../../../shared/element';
import type { Context, Part } from '../parts/part';
import { togglePicked } from '../state/picking';

const STILL = 5; // CSS pixels a click may wander
const NEAR = 0.006; // of D: a click so near to a picked vertex means that vertex
const PAUSE = 60; // milliseconds between two looks at the vertex under the pointer

export interface Pointer extends Part {
  /** The vertex under the pointer, in words; '' beside the face. */
  words(): string;
}

/** @param picture the element that the stage draws in. */
export function createPointer(context: Context, picture: HTMLElement): Pointer {
  const { store, stage, scene } = context;
  const tip = element('div', { class: 'tip', hidden: true, 'aria-hidden': 'true' });
  let words = '';
  let pressed: { x: number; y: number } | null = null;
  let place: { x: number; y: number } | null = null;
  let timer: ReturnType<typeof setTimeout> | null = null;
  let pause = PAUSE;

  const at = (event: PointerEvent) => {
    const bounds = picture.getBoundingClientRect();
    return { x: event.clientX - bounds.left, y: event.clientY - bounds.top };
  };

  const look = () => {
    timer = null;
    if (!place || pressed || !scene()) return leave();
    const before = performance.now();
    const found = stage.pick(place.x, place.y);
    // Reading back is slow on some machines: the picture comes first.
    pause = Math.max(PAUSE, 4 * (performance.now() - before));
    const state = store.get();
    words = found ? said(found) : '';
    setText(tip, words);
    tip.hidden = !found || !(state.heat || state.orbits);
    if (!found) return;
    const right = place.x > picture.clientWidth - 180;
    tip.style.left = right ? '' : `${place.x + 14}px`;
    tip.style.right = right ? `${picture.clientWidth - place.x + 14}px` : '';
    tip.style.top = `${Math.max(4, place.y - 30)}px`;
  };
  const said = (found: Pick) => {
    const diameter = scene()?.models[0]?.diameter ?? 0;
    if (found.distance === null) return `vertex ${found.vertex}`;
    const far = lengthAndShare(found.distance, scene()?.unit ?? '', diameter);
    return `vertex ${found.vertex}: ${far}`;
  };
  const leave = () => {
    words = '';
    tip.hidden = true;
  };

  picture.addEventListener('pointermove', (event) => {
    if (event.pointerType === 'touch') return;
    place = at(event);
    timer ??= setTimeout(look, pause);
  });
  picture.addEventListener('pointerleave', () => {
    place = null;
    leave();
  });
  picture.addEventListener('pointerdown', (event) => {
    pressed = event.isPrimary && event.button === 0 ? at(event) : null;
  });
  // Whoever turns the camera may capture the pointer or let it go outside.
  addEventListener('pointercancel', () => {
    pressed = null;
  });
  addEventListener('pointerup', (event) => {
    const start = pressed;
    pressed = null;
    if (!start || !event.isPrimary) return;
    const end = at(event);
    if (Math.hypot(end.x - start.x, end.y - start.y) > STILL) return;
    const state = store.get();
    if (!state.orbits || !scene()) return;
    const found = stage.pick(end.x, end.y);
    if (found) store.update(togglePicked(state, pickedNear(stage, scene, state, found)));
  });

  return {
    element: tip,
    words: () => words,
    show(state) {
      picture.dataset.picking = String(state.orbits);
    },
  };
}

// Vertices lie dense: a click beside the dot of a picked vertex is meant for it.
function pickedNear(
  stage: Stage,
  scene: Context['scene'],
  state: ViewState,
  found: Pick,
): number {
  if (state.picked.length === 0) return found.vertex;
  const positions = stage.positions(found.model);
  const reach = NEAR * (scene()?.models[0]?.diameter ?? 0);
  let [nearest, least] = [found.vertex, reach];
  for (const vertex of state.picked) {
    const distance = Math.hypot(
      ...found.position.map((x, axis) => x - (positions[3 * vertex + axis] ?? Infinity)),
    );
    if (distance <= least) [nearest, least] = [vertex, distance];
  }
  return nearest;
}
