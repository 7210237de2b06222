// The name of each model over its part of the picture, in the colour of its orbits.
import { colourOf, titleOf } from '../names/models';
import { element } from '../../../shared/element';
import type { Context, Part } from '../parts/part';

export function createLabels({ scene }: Context): Part {
  const whole = element('div', { class: 'labels' });
  let drawn = '';
  return {
    element: whole,
    show(state) {
      const models = scene()?.models ?? [];
      whole.hidden = models.length < 2;
      const now = JSON.stringify([state.arrangement, state.shown, models.map(titleOf)]);
      if (now === drawn) return;
      drawn = now;
      whole.dataset.arrangement = state.arrangement;
      whole.replaceChildren(
        ...state.shown.flatMap((number) => {
          const model = models[number];
          if (!model) return [];
          const swatch = element('span', { class: 'swatch', 'aria-hidden': 'true' });
          swatch.style.setProperty('--colour', colourOf(number));
          const name = element('span', { class: 'model-name' }, swatch, titleOf(model));
          return [element('div', { class: 'label' }, name)];
        }),
      );
    },
  };
}
