// What the colours of the heat map compare, and how far they reach.
import type { ViewState } from '../../types/state';
import { lengthAndShare } from '../names/lengths';
import { titleOf } from '../names/models';
import { toggle } from '../parts/controls';
import { element, freshId, setText } from '../../../shared/element';
import type { Context, Part } from '../parts/part';

const HEAT_NEEDS_TWO = 'Open a second file with the same vertices to measure distances.';

export function createHeat({ store, stage, scene }: Context): Part {
  const heat = toggle(store, 'heat', 'Heat map of distances', 'H');
  const against = element('select', { id: freshId('against') });
  const fixed = element('input', { type: 'checkbox', role: 'switch', id: freshId('fixed') });
  const top = element('input', {
    type: 'number',
    id: freshId('top'),
    min: 0.001,
    max: 100,
    step: 'any',
  });
  const meaning = element('p', { class: 'hint' });

  against.addEventListener('change', () => store.update({ against: Number(against.value) }));
  fixed.addEventListener('change', () => {
    const found = stage.readout().heat?.top;
    const diameter = scene()?.models[0]?.diameter ?? 1;
    const now = found && diameter > 0 ? found / diameter : 0.01;
    store.update({ heatTop: fixed.checked ? now : null });
  });
  top.addEventListener('change', () => {
    if (top.valueAsNumber > 0) store.update({ heatTop: top.valueAsNumber / 100 });
    top.value = percent(store.get());
  });

  const row = (label: string, input: HTMLElement, ...more: (Node | string)[]) =>
    element('div', { class: 'row' }, element('label', { for: input.id }, label), input, ...more);
  const topRow = row('Last colour, % of D', top);
  const againstRow = row('Measured from', against);
  const fixedRow = element(
    'div',
    { class: 'row toggle' },
    element('label', { for: fixed.id }, 'Fixed scale'),
    fixed,
  );

  return {
    element: element(
      'section',
      { class: 'block' },
      element('h2', {}, 'Distance'),
      heat.element,
      againstRow,
      fixedRow,
      topRow,
      meaning,
    ),
    load(found) {
      const models = found?.models ?? [];
      against.replaceChildren(
        ...models.map((model, value) => element('option', { value }, titleOf(model))),
      );
    },
    show(state) {
      const found = scene();
      const alone = (found?.models.length ?? 0) < 2;
      heat.show(state);
      heat.refuse(alone ? HEAT_NEEDS_TWO : null);
      for (const part of [againstRow, fixedRow]) part.hidden = alone;
      against.value = String(state.against);
      fixed.checked = state.heatTop !== null;
      topRow.hidden = alone || state.heatTop === null;
      meaning.hidden = topRow.hidden;
      if (document.activeElement !== top) top.value = percent(state);
      const diameter = found?.models[0]?.diameter ?? 0;
      const distance = (state.heatTop ?? 0) * diameter;
      setText(meaning, lengthAndShare(distance, found?.unit ?? '', diameter));
    },
  };
}

function percent(state: ViewState): string {
  return state.heatTop === null ? '' : String(Number((100 * state.heatTop).toPrecision(3)));
}
