// Labelled controls that show a field of the state and change it.
import type { ViewState } from '../../types/state';
import type { Store } from '../state/store';
import { element, freshId, setAttribute, setText } from '../../../shared/element';
import type { Part } from './part';

type FieldOf<T> = { [K in keyof ViewState]: ViewState[K] extends T ? K : never }[keyof ViewState];

export interface Control extends Part {
  /** Why the control cannot be used now; null where it can. */
  refuse(reason: string | null): void;
}

/** A switch for a field that is true or false. */
export function toggle(store: Store, field: FieldOf<boolean>, label: string, key = ''): Control {
  const box = element('input', { type: 'checkbox', role: 'switch' });
  box.addEventListener('change', () => store.update({ [field]: box.checked }));
  return {
    ...row('toggle', label, box, key),
    show: (state) => {
      box.checked = state[field] as boolean;
    },
  };
}

/** One of a few words, side by side. */
export function choice<K extends 'arrangement' | 'shading' | 'light' | 'theme'>(
  store: Store,
  field: K,
  label: string,
  options: readonly (readonly [ViewState[K], string])[],
): Part & { refuse(option: ViewState[K], reason: string | null): void } {
  const name = freshId(field);
  const reason = element('p', { class: 'reason', hidden: true, id: freshId('reason') });
  const boxes = options.map(([value]) => {
    const box = element('input', { type: 'radio', name, value });
    box.addEventListener('change', () => store.update({ [field]: value }));
    return box;
  });
  const labels = options.map(([, words], i) => element('label', {}, boxes[i], words));
  const whole = element(
    'fieldset',
    { class: 'choice' },
    element('legend', {}, label),
    element('div', { class: 'segments' }, ...labels),
    reason,
  );
  return {
    element: whole,
    show: (state) => {
      for (const box of boxes) box.checked = box.value === state[field];
    },
    refuse(option, words) {
      const box = boxes.find(({ value }) => value === option);
      if (!box) return;
      box.disabled = words !== null;
      setAttribute(box, 'aria-describedby', words !== null && reason.id);
      if (words) setText(reason, words);
      reason.hidden = boxes.every(({ disabled }) => !disabled);
    },
  };
}

/** A number on a scale, with what it means beside it. */
export function scale(
  store: Store,
  field: FieldOf<number>,
  label: string,
  range: { min: number; max: number; step: number },
  words: (value: number) => string,
): Control {
  const input = element('input', { type: 'range', ...range });
  const value = element('span', { class: 'value', 'aria-hidden': 'true' });
  input.addEventListener('input', () => store.update({ [field]: input.valueAsNumber }));
  const made = row('scale', label, input, '');
  made.element.querySelector('label')?.after(value);
  return {
    ...made,
    show: (state) => {
      const now = state[field] as number;
      if (input.valueAsNumber !== now) input.valueAsNumber = now;
      fill(input, range.min, now);
      const text = words(now);
      setText(value, text);
      input.setAttribute('aria-valuetext', text);
    },
  };
}

/** Colours the track of a slider between two values. */
export function fill(input: HTMLInputElement, from: number, to: number): void {
  const [min, max] = [Number(input.min), Number(input.max)];
  const percent = (value: number) =>
    `${(100 * Math.min(1, Math.max(0, (value - min) / (max - min)))).toFixed(2)}%`;
  input.style.setProperty('--from', percent(Math.min(from, to)));
  input.style.setProperty('--to', percent(Math.max(from, to)));
}

function row(kind: string, label: string, input: HTMLInputElement, key: string) {
  const id = freshId('control');
  const reason = element('p', { class: 'reason', id: freshId('reason'), hidden: true });
  input.id = id;
  const caption = element('label', { for: id }, label);
  if (key) {
    input.setAttribute('aria-keyshortcuts', key);
    caption.append(element('kbd', { 'aria-hidden': 'true' }, key));
  }
  return {
    element: element('div', { class: `row ${kind}` }, caption, input, reason),
    refuse(words: string | null) {
      input.disabled = words !== null;
      setText(reason, words ?? '');
      reason.hidden = words === null;
      setAttribute(input, 'aria-describedby', words !== null && reason.id);
    },
  };
}
