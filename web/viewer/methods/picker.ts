// Which method a target gets: one of a list, or any other by its text.
import { element, freshId, setText } from '../../shared/element';
import type { Row } from './bench';
import { shortly } from './figures';

const KEPT = 'kept'; // no method is called so
const OTHER = 'other';
const EXAMPLE = 'beam:3:rest';

export interface Picker {
  readonly element: HTMLElement;
  /** The methods to choose from. */
  offer(methods: readonly string[]): void;
  show(row: Row, chosen: string | null): void;
}

/** @param choose hears a method as text, '' for what holds without one, null for the present. */
export function methodPicker(choose: (method: string | null) => void): Picker {
  const list = element('select', { id: freshId('method') });
  const text = element('input', {
    type: 'text',
    'aria-label': `Another method, such as ${EXAMPLE}`,
    placeholder: EXAMPLE,
    spellcheck: 'false',
    hidden: true,
  });
  const name = element('h2', {});
  let methods: readonly string[] = [];
  let shown = '';

  list.addEventListener('change', () => {
    text.hidden = list.value !== OTHER;
    if (list.value === OTHER) text.focus();
    else choose(list.value === KEPT ? null : list.value);
  });
  text.addEventListener('change', () => {
    if (text.value.trim()) choose(text.value.trim());
  });

  return {
    element: element(
      'div',
      {},
      name,
      element('div', { class: 'row' }, element('label', { for: list.id }, 'Method'), list),
      text,
    ),
    offer: (found) => {
      methods = found;
      shown = '';
    },
    show(row, chosen) {
      setText(name, row.name);
      const key = JSON.stringify([row.name, row.said, row.method, methods.length]);
      if (key !== shown) {
        shown = key;
        text.hidden = true;
        const option = (value: string, words: string) => element('option', { value }, words);
        list.replaceChildren(
          option(KEPT, `As now: ${shortly(row.method)}`),
          ...(row.said && row.laws.length === 0 ? [option('', 'None of its own')] : []),
          ...(row.laws.length > 0 ? row.laws : methods).map((method) => option(method, method)),
          ...(row.laws.length > 0 ? [] : [option(OTHER, 'Another…')]),
        );
      }
      const offered = [...list.options].some(({ value }) => value === chosen);
      if (chosen !== null && !offered) {
        text.hidden = false;
        if (document.activeElement !== text) text.value = chosen;
      } else if (document.activeElement !== text) text.hidden = true;
      if (text.hidden || chosen !== null) list.value = chosen === null ? KEPT : offered ? chosen : OTHER;
    },
  };
}
