// Which sliders are shown: by words of their names, the active ones, the favourites.
import { numberOf } from '../../../shared/named';
import { element, setAttribute, setText } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import type { ViewState } from '../../types/state';
import type { SliderRow } from './slider_row';

/** @param changed hears that others are to be shown. */
export function createSift(changed: () => void) {
  let starred = false;
  const field = element('input', {
    type: 'search',
    placeholder: 'Search sliders',
    'aria-label': 'Search sliders',
    'aria-keyshortcuts': '/',
    autocomplete: 'off',
    spellcheck: 'false',
  });
  const active = element('input', { type: 'checkbox' });
  const star = element(
    'button',
    {
      type: 'button',
      class: 'star',
      title: 'Show only favourites',
      'aria-label': 'Favourites only',
      'aria-pressed': 'false',
    },
    icon('star'),
  );
  const none = element('p', { class: 'hint', hidden: true });
  const words = () => field.value.toLowerCase().split(/\s+/).filter(Boolean);

  field.addEventListener('input', changed);
  active.addEventListener('change', changed);
  star.addEventListener('click', () => {
    starred = !starred;
    setAttribute(star, 'aria-pressed', String(starred));
    changed();
  });

  return {
    element: element(
      'div',
      { class: 'slider-search' },
      element('div', { class: 'search' }, icon('search'), field),
      star,
    ),
    onlyActive: element(
      'label',
      { class: 'check', title: 'Show only sliders that are not 0' },
      active,
      'Active only',
    ),
    /** What is said where no slider is shown. */
    none,
    searching: () => words().length > 0,
    fits(state: Pick<ViewState, 'weights' | 'favourites'>): (row: Pick<SliderRow, 'name'>) => boolean {
      const wanted = words();
      return ({ name }) =>
        wanted.every((word) => name.toLowerCase().includes(word)) &&
        (!active.checked || numberOf(state.weights, name) !== 0) &&
        (!starred || state.favourites.includes(name));
    },
    /** Says why of so many sliders none is shown. */
    tell(count: number, shown: number) {
      none.hidden = shown > 0;
      const kind = [starred && 'a favourite', active.checked && 'active'].filter(Boolean);
      setText(
        none,
        count === 0
          ? 'This model has no morph targets, so there is nothing to move.'
          : words().length > 0
            ? `No slider is called “${field.value}”${kind.map((one) => ` and ${one}`).join('')}.`
            : `No slider is ${kind.join(' and ')}${starred ? ': its star makes it one' : ''}.`,
      );
    },
    search() {
      field.focus();
      field.select();
    },
    clear(): boolean {
      if (field.value === '') return false;
      field.value = '';
      changed();
      return true;
    },
  };
}
