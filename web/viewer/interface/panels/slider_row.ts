// One slider: its name, the slider itself, its number, and a button back to zero.
import { element, setAttribute } from '../../../shared/element';
import { fill } from '../parts/controls';
import { icon } from '../../../shared/icons';

export interface SliderRow {
  readonly name: string;
  readonly element: HTMLElement;
  /** The weight it shows. */
  show(weight: number, paired: boolean, favourite: boolean): void;
  /** How far it reaches: 0 to 1, or beyond. */
  reach(least: number, most: number): void;
}

let numbered = 0;

/**
 * @param change hears what somebody moves it to.
 * @param star hears that it is to be a favourite, or is to be one no more.
 */
export function sliderRow(
  name: string,
  change: (weight: number) => void,
  star: () => void,
): SliderRow {
  numbered += 1;
  const id = `slider-${numbered}`;
  const range = element('input', { type: 'range', id, min: 0, max: 1, step: 0.01, value: 0 });
  const number = element('input', {
    type: 'number',
    'aria-label': `${name}, value`,
    min: 0,
    max: 1,
    step: 0.01,
    value: '0.00',
  });
  const zero = element('button', { type: 'button', class: 'zero', 'aria-label': `${name} to 0` });
  zero.title = 'Back to 0';
  zero.append(icon('zero'));
  // Its key is S: with a stop for each of them the way through the list would be twice as long.
  const starred = element('button', {
    type: 'button',
    class: 'star',
    tabindex: -1,
    title: 'Favourite (S)',
    'aria-label': `${name}, favourite`,
    'aria-pressed': 'false',
    onclick: star,
  });
  starred.append(icon('star'));
  const whole = element(
    'div',
    { class: 'slider', 'data-slider': name },
    starred,
    element('label', { for: id, title: name }, name),
    range,
    number,
    zero,
  );

  let shown = 0;
  let shownPaired = false;
  range.addEventListener('input', () => change(range.valueAsNumber));
  number.addEventListener('input', () => {
    const typed = number.valueAsNumber;
    if (!Number.isFinite(typed)) return;
    change(Math.min(Number(number.max), Math.max(Number(number.min), typed)));
  });
  number.addEventListener('beforeinput', (event) => {
    if (event.data !== ',' || (0.5).toLocaleString().includes(',')) return;
    event.preventDefault(); // browsers would leave the comma out, and 0,5 would be 05
    document.execCommand('insertText', false, '.');
  });
  number.addEventListener('blur', () => write(shown));
  zero.addEventListener('click', () => {
    change(0);
    range.focus(); // the button goes as the weight does
  });

  const write = (weight: number) => {
    const text = weight.toFixed(2);
    if (document.activeElement !== number || number.valueAsNumber !== weight) {
      if (number.value !== text) number.value = text;
    }
  };

  return {
    name,
    element: whole,
    show(weight, paired, favourite) {
      setAttribute(starred, 'aria-pressed', String(favourite));
      // Moved by hand to where the face did not follow, the thumb goes back too.
      if (weight !== shown || Math.abs(range.valueAsNumber - weight) > 0.005) {
        shown = weight;
        range.valueAsNumber = weight;
        write(weight);
        fill(range, 0, weight);
        setAttribute(whole, 'data-active', weight !== 0);
      }
      if (paired !== shownPaired) {
        shownPaired = paired;
        setAttribute(whole, 'data-paired', paired);
      }
    },
    reach(least, most) {
      for (const input of [range, number]) {
        input.min = String(least);
        input.max = String(most);
      }
      range.valueAsNumber = shown; // a narrower range had clamped it
      setAttribute(whole, 'data-beyond', least < 0);
      fill(range, 0, shown);
    },
  };
}
