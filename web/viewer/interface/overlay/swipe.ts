// The line between two models over one head, dragged or moved by keys.
import { titleOf } from '../names/models';
import { element } from '../../../shared/element';
import type { Context, Part } from '../parts/part';

const STEPS: Readonly<Record<string, number>> = {
  ArrowLeft: -0.01,
  ArrowDown: -0.01,
  ArrowRight: 0.01,
  ArrowUp: 0.01,
  PageDown: -0.1,
  PageUp: 0.1,
  Home: -1,
  End: 1,
};

export function createSwipe({ store, scene }: Context): Part {
  const knob = element('span', { class: 'knob', 'aria-hidden': 'true' }, '◂ ▸');
  const handle = element(
    'div',
    {
      class: 'swipe',
      role: 'slider',
      tabindex: 0,
      'aria-orientation': 'horizontal',
      'aria-valuemin': 0,
      'aria-valuemax': 100,
    },
    knob,
  );

  const drag = (event: PointerEvent) => {
    if (!handle.hasPointerCapture(event.pointerId)) return;
    const bounds = handle.parentElement?.getBoundingClientRect();
    if (bounds) store.update({ swipe: (event.clientX - bounds.left) / bounds.width });
  };
  handle.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    handle.setPointerCapture(event.pointerId);
    handle.focus();
    event.preventDefault();
  });
  handle.addEventListener('pointermove', drag);
  handle.addEventListener('keydown', (event) => {
    const step = STEPS[event.key];
    if (step === undefined || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    store.update({ swipe: store.get().swipe + step });
  });

  return {
    element: handle,
    show(state) {
      handle.hidden = state.arrangement !== 'swipe';
      if (handle.hidden) return;
      const percent = Math.round(100 * state.swipe);
      handle.style.left = `${100 * state.swipe}%`;
      handle.setAttribute('aria-valuenow', String(percent));
      const [left, right] = state.shown.map((model) => scene()?.models[model]);
      if (!left || !right) return;
      handle.setAttribute('aria-label', `Swipe between ${titleOf(left)} and ${titleOf(right)}`);
      handle.setAttribute(
        'aria-valuetext',
        `${percent} % ${titleOf(left)}, ${100 - percent} % ${titleOf(right)}`,
      );
    },
  };
}
