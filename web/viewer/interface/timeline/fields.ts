// Small fields of the timeline: a number with its name and unit.
import { element, setText } from '../../../shared/element';

interface Options {
  readonly step: number | 'any';
  readonly title: string;
  readonly min?: number;
  readonly max?: number;
  readonly unit?: string;
}

export interface NumberField {
  readonly element: HTMLElement;
  readonly input: HTMLInputElement;
  /** The number, within its bounds; 0 while there is none. */
  value(): number;
  unit(words: string): void;
  /** What it says, unless somebody is typing. */
  show(text: string): void;
}

export function numberField(name: string, { unit = '', ...options }: Options): NumberField {
  const input = element('input', { type: 'number', 'aria-label': name, ...options });
  let typing = false;
  // Whoever comes into it finds it as it is, with what is selected to be typed over.
  for (const start of ['focus', 'input'])
    input.addEventListener(start, () => (typing = true));
  const end = (text: string, none: number) => (text === '' ? none : Number(text));
  const within = () => {
    const number = Math.max(end(input.min, -Infinity), input.valueAsNumber);
    return Math.min(end(input.max, Infinity), number) || 0;
  };
  input.addEventListener('change', () => {
    if (Number.isFinite(input.valueAsNumber) && input.valueAsNumber !== within())
      input.value = String(within());
  });
  for (const done of ['change', 'blur']) input.addEventListener(done, () => (typing = false));
  const after = element('span', { class: 'unit' }, unit);
  return {
    element: element('label', { class: 'field', title: options.title }, name, input, after),
    input,
    value: within,
    unit: (words) => setText(after, words),
    show: (text) => {
      if (!typing && input.value !== text) input.value = text;
    },
  };
}
