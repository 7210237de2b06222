// The button on the picture that turns grabbing on, and what else it needs: a vertex and pins.
import { element, freshId, setText } from '../../shared/element';
import { icon } from '../../shared/icons';
import type { ViewState } from '../types/state';

export interface BarDeeds {
  toggle(): void;
  /** Takes the vertex of a number. */
  hold(vertex: number): void;
  /** Pins what is held, or lets it go. */
  pin(): void;
  clear(): void;
}

export interface Bar {
  readonly element: HTMLElement;
  show(state: ViewState, vertices: number, held: number | null): void;
}

export function createBar(deeds: BarDeeds): Bar {
  const id = freshId('grabbed');
  const button = (words: string, run: () => void, ...more: (Node | string)[]) => {
    const made = element('button', { type: 'button', title: words, 'aria-label': words }, ...more);
    made.addEventListener('click', run);
    return made;
  };
  const grab = button('Grab the face (D)', deeds.toggle, icon('grab'));
  grab.setAttribute('aria-keyshortcuts', 'D');
  const number = element('input', { type: 'number', id, min: 0, step: 1, placeholder: '–' });
  const form = element('form', {}, element('label', { for: id }, 'Vertex'), number);
  const take = () => {
    if (number.value !== '' && number.validity.valid) deeds.hold(number.valueAsNumber);
  };
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    take();
  });
  number.addEventListener('change', take);
  const pin = button('Pin the vertex: it holds still (Shift+click)', deeds.pin, icon('pin'));
  const clear = element('button', { type: 'button' });
  clear.addEventListener('click', () => {
    deeds.clear();
    grab.focus(); // the button goes as the pins do
  });
  const more = element('div', { class: 'grab-more' }, form, pin, clear);
  return {
    element: element(
      'div',
      { class: 'grab-bar', role: 'group', 'aria-label': 'Grab' },
      more,
      grab,
    ),
    show(state, vertices, held) {
      grab.setAttribute('aria-pressed', String(state.grab));
      grab.disabled = vertices === 0;
      more.hidden = !state.grab;
      number.max = String(Math.max(0, vertices - 1));
      if (document.activeElement !== number) number.value = held === null ? '' : String(held);
      pin.disabled = held === null;
      pin.setAttribute('aria-pressed', String(held !== null && state.pins.includes(held)));
      clear.hidden = state.pins.length === 0;
      setText(clear, state.pins.length === 1 ? 'Clear 1 pin' : `Clear ${state.pins.length} pins`);
    },
  };
}
