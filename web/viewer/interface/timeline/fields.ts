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
  /** The number; 0 while there is none. */
  value(): number;
  unit(words: string): void;
}

export function numberField(name: string, { unit = '', ...options }: Options): NumberField {
  const input = element('input', { type: 'number', 'aria-label': name, ...options });
  const after = element('span', { class: 'unit' }, unit);
  return {
    element: element('label', { class: 'field', title: options.title }, name, input, after),
    input,
    value: () => (Number.isFinite(input.valueAsNumber) ? input.valueAsNumber : 0),
    unit: (words) => setText(after, words),
  };
}
