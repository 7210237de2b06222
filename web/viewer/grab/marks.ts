// What lies over the face while it is grabbed: pins, the point that is held, and where it is wanted.
import { element } from '../../shared/element';
import type { Model } from '../types/model';
import type { Stage } from '../types/stage';
import type { ViewState } from '../types/state';
import type { Reached } from './gesture';
import { Points } from './points';

/** A vertex of a model that arrow keys move. */
export interface Held {
  readonly model: number;
  readonly vertex: number;
}

export interface Marks {
  readonly element: HTMLElement;
  /** Draws them anew, or nothing at all; `reached` of the point that is held. */
  show(state: ViewState, visible: boolean, held: Held | null, reached: Reached | null): void;
  /** The picture was drawn: they follow. */
  follow(): void;
  /** The pin or held vertex drawn near a place, in CSS pixels. */
  near(x: number, y: number): Held | null;
}

interface Mark extends Held {
  readonly element: HTMLElement;
}

export interface PinDeeds {
  hold(held: Held): void;
  remove(vertex: number): void;
}

const NEAR = 14; // CSS pixels

export function createMarks(
  stage: Stage,
  models: () => readonly Model[],
  deeds: PinDeeds,
): Marks {
  const svg = (tag: string, name: string) => {
    const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
    made.setAttribute('class', name);
    return made;
  };
  const drawing = svg('svg', 'wanting');
  const line = svg('line', 'want-line');
  const ring = svg('circle', 'want-ring');
  ring.setAttribute('r', '6');
  drawing.setAttribute('aria-hidden', 'true');
  drawing.append(line, ring);
  const pins = element('div', { class: 'pins', role: 'group', 'aria-label': 'Pins' });
  const whole = element('div', { class: 'grab-marks', hidden: true });
  whole.append(drawing, pins);

  let marks: Mark[] = [];
  let made = '';
  let shown: ViewState | null = null;
  let wanted: Reached | null = null;
  let heldOn: Held | null = null;
  const points = new WeakMap<Model, Points>(); // of the marks that are there now

  const markOf = (one: Held, pinned: boolean, held: boolean): Mark => {
    const words = `Pin at vertex ${one.vertex}. Arrow keys move it, Delete removes it`;
    const mark = pinned
      ? element('button', { type: 'button', class: 'pin', 'aria-label': words, title: words })
      : element('span', { class: 'pin', 'aria-hidden': 'true' });
    mark.toggleAttribute('data-held', held);
    mark.toggleAttribute('data-pinned', pinned);
    mark.addEventListener('focus', () => deeds.hold(one));
    mark.addEventListener('keydown', (event) => {
      if (event.key !== 'Delete' && event.key !== 'Backspace') return;
      event.preventDefault();
      deeds.remove(one.vertex);
    });
    return { ...one, element: mark };
  };

  const make = (state: ViewState, held: Held | null) => {
    const now = JSON.stringify([state.shown, state.pins, held, state.correctivesOff]);
    if (now === made) return;
    made = now;
    const focused = marks.find((mark) => mark.element === document.activeElement);
    const isHeld = (one: Held) => held?.model === one.model && held.vertex === one.vertex;
    const all = state.shown.flatMap((model) =>
      state.pins.map((vertex) => ({ model, vertex })),
    );
    marks = all.map((one) => markOf(one, true, isHeld(one)));
    if (held && !all.some(isHeld)) marks.push(markOf(held, false, true));
    pins.replaceChildren(...marks.map((mark) => mark.element));
    const again = marks.find((m) => m.model === focused?.model && m.vertex === focused.vertex);
    again?.element.focus({ preventScroll: true });
    for (const number of state.shown) {
      const model = models()[number];
      const own = marks.filter((mark) => mark.model === number).map(({ vertex }) => vertex);
      if (model) points.set(model, new Points(model, own, state.correctivesOff));
    }
  };

  const follow = () => {
    if (!shown || whole.hidden) return;
    const { weights, t } = shown;
    for (const number of new Set(marks.map(({ model }) => model))) {
      const model = models()[number];
      const own = model && points.get(model);
      if (!model || !own) continue;
      const values = Float64Array.from(model.bender.values(weights), (weight) => t * weight);
      const { positions } = own.at(values, []);
      marks
        .filter((mark) => mark.model === number)
        .forEach(({ element: mark }, i) => {
          const at = stage.spot(number, positions.subarray(3 * i, 3 * i + 3));
          mark.hidden = !at?.drawn;
          if (at) mark.style.translate = `${at.x}px ${at.y}px`;
        });
    }
    const model = heldOn?.model ?? 0;
    const [from, to] = wanted
      ? [stage.spot(model, wanted.position), stage.spot(model, wanted.goal)]
      : [];
    drawing.toggleAttribute('hidden', !from || !to);
    if (!from || !to || !wanted) return;
    for (const [name, place] of [['1', from], ['2', to]] as const) {
      line.setAttribute(`x${name}`, String(place.x));
      line.setAttribute(`y${name}`, String(place.y));
    }
    line.toggleAttribute('hidden', wanted.left === 0);
    ring.setAttribute('cx', String(to.x));
    ring.setAttribute('cy', String(to.y));
  };

  return {
    element: whole,
    show(state, visible, held, reached) {
      whole.hidden = !visible;
      [shown, wanted, heldOn] = [state, reached, held];
      make(state, held);
      follow();
    },
    follow,
    near(x, y) {
      const bounds = whole.getBoundingClientRect();
      let [found, least]: [Held | null, number] = [null, NEAR];
      for (const mark of marks) {
        if (mark.element.hidden) continue;
        const box = mark.element.getBoundingClientRect();
        const away = Math.hypot(
          (box.left + box.right) / 2 - bounds.left - x,
          (box.top + box.bottom) / 2 - bounds.top - y,
        );
        if (away < least) [found, least] = [{ model: mark.model, vertex: mark.vertex }, away];
      }
      return found;
    },
  };
}
