// How much of a pose is taken, and whether in the place of the present one or on top of it.
import { element, setText } from '../../../shared/element';
import { fill } from '../parts/controls';

/** @param changed hears of another strength, from 0 to 1, and whether the pose is added. */
export function createMixing(changed: (strength: number, onTop: boolean) => void) {
  const range = element('input', {
    type: 'range',
    'aria-label': 'Strength of the pose',
    min: 0,
    max: 1,
    step: 0.01,
    value: 1,
  });
  const value = element('span', { class: 'value', 'aria-hidden': 'true' }, '100 %');
  const box = element('input', { type: 'checkbox' });
  const tell = () => {
    const percent = `${Math.round(100 * range.valueAsNumber)} %`;
    fill(range, 0, range.valueAsNumber);
    setText(value, percent);
    range.setAttribute('aria-valuetext', percent);
    changed(range.valueAsNumber, box.checked);
  };
  for (const input of [range, box]) input.addEventListener('input', tell);
  fill(range, 0, 1);
  return {
    element: element(
      'div',
      { class: 'pose-mixing' },
      element('span', { 'aria-hidden': 'true' }, 'Strength'),
      range,
      value,
      element('label', { class: 'check', title: 'Add the pose to the present one' }, box, 'On top'),
    ),
    strength: () => range.valueAsNumber,
    onTop: () => box.checked,
  };
}
