// Sliders of one part of the face below a heading that folds them away.
import { numberOf } from '../../../shared/named';
import { element, setAttribute, setText } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import type { ViewState } from '../../types/state';
import type { SliderRow } from './slider_row';

export interface SliderGroup {
  readonly name: string;
  readonly element: HTMLElement;
  readonly rows: readonly SliderRow[];
  /** Shows the rows that fit and says how many of all are active; returns how many are shown. */
  show(state: ViewState, fits: (row: SliderRow) => boolean, folded: boolean): number;
}

/**
 * @param fold hears that the group is to fold, or to unfold.
 * @param zero hears that all its sliders are to be 0.
 */
export function sliderGroup(
  name: string,
  rows: readonly SliderRow[],
  fold: () => void,
  zero: () => void,
): SliderGroup {
  const count = element('span', { class: 'count' });
  const opener = element('button', { type: 'button', onclick: fold }, icon('chevron'), name, count);
  const words = `${name}: all to 0`;
  const reset = element('button', { type: 'button', class: 'zero', onclick: zero }, icon('zero'));
  [reset.title, reset.ariaLabel] = [words, words];
  const body = element('div', { class: 'rows' }, ...rows.map((row) => row.element));
  const whole = element('section', { class: 'group' }, element('h2', {}, opener, reset), body);
  return {
    name,
    element: whole,
    rows,
    show(state, fits, folded) {
      const active = rows.filter((row) => numberOf(state.weights, row.name) !== 0).length;
      setText(count, active > 0 ? `${active} of ${rows.length}` : '');
      setAttribute(whole, 'data-active', active > 0);
      setAttribute(opener, 'aria-expanded', String(!folded));
      let fitting = 0;
      for (const row of rows) {
        // A row that is being moved stays, though it passes through zero.
        row.element.hidden = !fits(row) && !row.element.contains(document.activeElement);
        if (!row.element.hidden) fitting += 1;
      }
      body.hidden = folded;
      whole.hidden = fitting === 0;
      return fitting;
    },
  };
}
