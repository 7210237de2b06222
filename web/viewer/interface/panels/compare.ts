// Which models are seen and how: alone, side by side, or one over the other.
import type { Model } from '../../types/model';
import type { ViewState } from '../../types/state';
import { colourOf, titleOf } from '../names/models';
import { choice, scale, toggle } from '../parts/controls';
import { element } from '../../../shared/element';
import type { Context, Part } from '../parts/part';

const ONE_MODEL = 'Open a second file with the same vertices to compare.';

export function createCompare({ store, scene }: Context): Part {
  const arrangement = choice(store, 'arrangement', 'Arrangement', [
    ['single', 'Single'],
    ['side', 'Side by side'],
    ['swipe', 'Swipe'],
  ]);
  const places = element('div', { class: 'places' });
  const ghost = toggle(store, 'ghost', 'Ghost of the neutral', 'G');
  const onion = scale(store, 'onion', 'In-betweens', { min: 0, max: 9, step: 1 }, (n) =>
    n === 0 ? 'none' : String(n),
  );
  let drawn = '';

  // One choice of a model for each part of the picture, and a button for a third part.
  const drawPlaces = (state: ViewState, models: readonly Model[]) => {
    const now = JSON.stringify([state.shown, state.arrangement, models.map(({ name }) => name)]);
    if (now === drawn) return;
    const at = [...places.querySelectorAll('select, button')].indexOf(
      document.activeElement as Element,
    );
    drawn = now;
    places.replaceChildren(
      ...state.shown.map((shown, place) => placeRow(state, models, shown, place)),
    );
    if (state.arrangement === 'side' && state.shown.length === 2 && models.length > 2) {
      const third = models.findIndex((_, model) => !state.shown.includes(model));
      const add = element('button', { type: 'button' }, 'Add a third');
      add.addEventListener('click', () => store.update({ shown: [...state.shown, third] }));
      places.append(add);
    }
    if (at >= 0) places.querySelectorAll<HTMLElement>('select, button')[at]?.focus();
  };

  const placeRow = (
    state: ViewState,
    models: readonly Model[],
    shown: number,
    place: number,
  ): HTMLElement => {
    const words = placeName(state, place);
    const pick = element(
      'select',
      { 'aria-label': `Model shown ${words.toLowerCase()}` },
      ...models.map((model, value) => element('option', { value }, titleOf(model))),
    );
    pick.value = String(shown);
    pick.addEventListener('change', () => {
      const wanted = Number(pick.value);
      const other = state.shown.indexOf(wanted); // a model seen already changes places
      const next = state.shown.map((model, i) => (i === other ? shown : model));
      next[place] = wanted;
      store.update({ shown: next });
    });
    const swatch = element('span', { class: 'swatch', 'aria-hidden': 'true' });
    swatch.style.setProperty('--colour', colourOf(shown));
    const row = element('div', { class: 'place' }, swatch, element('span', {}, words), pick);
    if (state.shown.length === 3) {
      const remove = element('button', { type: 'button', 'aria-label': `Remove ${words}` }, '×');
      remove.addEventListener('click', () =>
        store.update({ shown: state.shown.filter((_, i) => i !== place) }),
      );
      row.append(remove);
    }
    return row;
  };

  return {
    element: element(
      'section',
      { class: 'block' },
      element('h2', {}, 'Models'),
      arrangement.element,
      places,
      ghost.element,
      onion.element,
    ),
    show(state) {
      const models = scene()?.models ?? [];
      arrangement.show(state);
      for (const option of ['side', 'swipe'] as const) {
        arrangement.refuse(option, models.length < 2 ? ONE_MODEL : null);
      }
      drawPlaces(state, models);
      ghost.show(state);
      onion.show(state);
    },
  };
}

function placeName(state: ViewState, place: number): string {
  if (state.arrangement === 'single') return 'Shown';
  if (state.shown.length === 3) return ['Left', 'Middle', 'Right'][place] ?? '';
  return place === 0 ? 'Left' : 'Right';
}
