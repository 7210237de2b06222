// Grabbing the face: a point is pressed and dragged, or moved by keys, and the sliders follow.
import type { Context, Part } from '../interface/parts/part';
import { digits } from '../interface/names/lengths';
import { element } from '../../shared/element';
import type { Position } from '../types/stage';
import type { ViewState } from '../types/state';
import { createBar } from './bar';
import { Gesture, type Reached } from './gesture';
import { createMarks, type Held } from './marks';

const CLICK = 4; // CSS pixels a click may wander
const NUDGE = 4; // CSS pixels of an arrow key; with Shift five times as many
const MANY = 64; // pins; more of them leave nothing to move
const OF_GESTURE = ['weights', 't', 'pins', 'mirror', 'shown', 'correctivesOff'] as const;

export interface GrabTool extends Part {
  toggle(): void;
  /** Moves the held vertex across the picture; false where none is held. */
  nudge(right: number, up: number, far: boolean): boolean;
  /** Ends the drag, lets the vertex go or leaves the tool; false where there is nothing to leave. */
  leave(): boolean;
  /** What the grabbed vertex does, in words; '' where there is nothing to say. */
  words(): string;
}

interface Drag {
  readonly pointer: number;
  readonly gesture: Gesture;
  readonly before: ViewState;
  readonly from: Position; // under the pointer when it was pressed
  readonly pressed: readonly [number, number];
  to: readonly [number, number];
  moving: boolean;
}

/**
 * @param picture the element that the stage draws in
 * @param moved hears which sliders a gesture has moved, and whether it is over
 */
export function createGrab(
  { store, stage, scene, tell }: Context,
  picture: HTMLElement,
  moved: (sliders: readonly string[], over: boolean) => void,
): GrabTool {
  let drag: Drag | null = null;
  let held: Held | null = null;
  let reached: Reached | null = null;
  let last: { gesture: Gesture; left: ViewState; to: Position } | null = null; // and what it left
  let waiting = 0;

  const forget = () => {
    [reached, last] = [null, null];
  };
  const models = () => scene()?.models ?? [];
  const hold = (one: Held | null) => {
    if (one?.model === held?.model && one?.vertex === held?.vertex) return;
    held = one;
    forget();
    show(store.get());
  };
  const togglePin = (vertex: number) => {
    const { pins } = store.get();
    const without = pins.filter((pin) => pin !== vertex);
    store.update({ pins: pins.includes(vertex) ? without : [...pins, vertex].slice(-MANY) });
  };
  const marks = createMarks(stage, models, { hold, remove: togglePin });
  stage.drawn(marks.follow);
  const bar = createBar({
    toggle: () => toggle(),
    hold: (vertex) => {
      hold({ model: store.get().shown[0] ?? 0, vertex });
      picture.focus();
    },
    pin: () => held && togglePin(held.vertex),
    clear: () => store.update({ pins: [] }),
  });
  const whole = element('div', { class: 'grab' }, marks.element, bar.element);

  const show = (state: ViewState) => {
    const vertices = (models()[0]?.neutral.length ?? 0) / 3;
    if (held && (held.vertex >= vertices || !state.shown.includes(held.model))) held = null;
    // Whoever moves a slider by hand has taken the point elsewhere.
    if (last && OF_GESTURE.some((field) => state[field] !== last?.left[field])) forget();
    marks.show(state, state.grab || drag !== null, held, reached);
    bar.show(state, vertices, held?.vertex ?? null);
    picture.dataset.grab = drag?.moving ? 'dragging' : String(state.grab);
  };

  const toggle = () => {
    cancel();
    hold(null);
    store.update({ grab: !store.get().grab });
  };

  // A performance that plays, or a phone, gives the sliders away, as it does when one of them is moved.
  const begun = (one: Held): Gesture | null => {
    const state = store.get();
    const model = models()[one.model];
    if (!model) return null;
    const t = state.t > 0 ? state.t : 1;
    const gesture = Gesture.at(model, one.vertex, { ...state, t }, stage.eye());
    if (!gesture) tell(`No slider moves vertex ${one.vertex}.`);
    else store.update({ clip: null, playing: false, live: false, t });
    return gesture;
  };

  const pull = (gesture: Gesture, to: Position) => {
    reached = gesture.pull(to);
    store.update({ weights: reached.weights });
    last = { gesture, left: store.get(), to };
    moved(gesture.moved(reached.weights), false);
  };

  const at = (event: PointerEvent): [number, number] => {
    const bounds = picture.getBoundingClientRect();
    return [event.clientX - bounds.left, event.clientY - bounds.top];
  };

  const step = () => {
    waiting = 0;
    if (!drag?.moving || !held) return;
    const { gesture, from, to } = drag;
    const now = stage.across(held.model, gesture.from, ...to);
    const [x, y, z] = now.map((own, axis) => gesture.from[axis]! + own - from[axis]!);
    pull(gesture, [x!, y!, z!]);
  };

  const cancel = () => {
    if (!drag) return;
    const { before } = drag;
    end();
    forget();
    store.update({ weights: before.weights, t: before.t });
  };
  const end = () => {
    cancelAnimationFrame(waiting);
    waiting = 0;
    drag = null;
    if (!store.get().grab) held = null;
  };

  const press = (event: PointerEvent) => {
    const taken = event.button === 0 && !event.ctrlKey && !event.metaKey;
    const { grab } = store.get();
    if (drag) return event.stopImmediatePropagation(); // a second finger
    // Alt is for a moment what the tool is, and with the tool turns the camera.
    if (!taken || !event.isPrimary || grab === event.altKey || !scene()) return;
    const place = at(event);
    const one = marks.near(...place) ?? stage.pick(...place);
    if (!one) return;
    event.stopImmediatePropagation();
    const on: Held = { model: one.model, vertex: one.vertex };
    if (event.shiftKey) {
      togglePin(on.vertex);
      return;
    }
    const before = store.get();
    const gesture = begun(on);
    if (!gesture) return;
    hold(on);
    const from = stage.across(on.model, gesture.from, ...place);
    drag = { pointer: event.pointerId, gesture, before, from, pressed: place, to: place, moving: false };
    picture.setPointerCapture(event.pointerId);
    show(store.get());
  };
  const move = (event: PointerEvent) => {
    if (!drag) return;
    event.stopImmediatePropagation();
    if (event.pointerId !== drag.pointer) return;
    drag.to = at(event);
    const [x, y] = drag.pressed;
    drag.moving ||= Math.hypot(drag.to[0] - x, drag.to[1] - y) > CLICK;
    waiting ||= requestAnimationFrame(step);
  };
  const release = (event: PointerEvent) => {
    if (!drag || event.pointerId !== drag.pointer) return;
    event.stopImmediatePropagation();
    if (waiting) step();
    const { gesture, moving } = drag;
    end();
    if (moving) moved(gesture.moved(store.get().weights), true);
    show(store.get());
  };
  picture.addEventListener('pointerdown', press, true);
  picture.addEventListener('pointermove', move, true);
  picture.addEventListener('pointerup', release, true);
  picture.addEventListener('pointercancel', (event) => drag?.pointer === event.pointerId && cancel());

  return {
    element: whole,
    show,
    load() {
      end();
      hold(null);
    },
    toggle,
    nudge(right, up, far) {
      if (!held || !store.get().grab) return false;
      const gesture = last?.gesture ?? begun(held);
      if (!gesture) return true;
      const from = last && reached?.left === 0 ? last.to : (reached?.position ?? gesture.from);
      const place = stage.spot(held.model, from);
      if (!place) return true;
      const by = far ? 5 * NUDGE : NUDGE;
      pull(gesture, stage.across(held.model, from, place.x + by * right, place.y - by * up));
      moved(gesture.moved(store.get().weights), true);
      return true;
    },
    leave() {
      if (drag) cancel();
      else if (held) hold(null);
      else if (store.get().grab) store.update({ grab: false });
      else return false;
      return true;
    },
    words() {
      const state = store.get();
      if (!state.grab && !drag) return '';
      if (reached && reached.left > 0)
        return `${digits(reached.left)} ${scene()?.unit ?? ''} out of reach`.replace('  ', ' ');
      return held ? '' : 'drag the face; Shift+click pins a vertex';
    },
  };
}
