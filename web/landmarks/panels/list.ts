// The points by name: which is placed next, and in how many photographs each is.
import { element, setAttribute, setText } from '../../shared/element';
import { icon } from '../../shared/icons';

export interface Row {
  readonly name: string;
  readonly here: boolean;
  readonly count: number;
  /** Distance in pixels from where all photographs together put it; null where none is known. */
  readonly residual: number | null;
  readonly off: boolean;
}

export interface PointList {
  readonly element: HTMLElement;
  show(rows: readonly Row[], active: string | null): void;
}

const RESIDUAL = 'Distance from where all photographs together put the point';

/** A name as people read it. */
export function readable(name: string): string {
  const words = name.replaceAll('_', ' ');
  return words[0]!.toUpperCase() + words.slice(1);
}

export function createList(
  names: readonly string[],
  asked: number, // photographs of each point; 0 where there are none
  choose: (name: string) => void,
  remove: (name: string) => void,
): PointList {
  const rows = names.map((name) => {
    const dots = Array.from({ length: asked }, () => element('i'));
    const count = element('span', { class: 'count', 'aria-hidden': 'true' }, ...dots);
    const residual = element('span', { class: 'residual', title: RESIDUAL });
    const said = element('span', { class: 'said' });
    const button = element(
      'button',
      { type: 'button', class: 'point', 'data-name': name },
      element('span', { class: 'tick', 'aria-hidden': 'true' }),
      element('span', { class: 'name' }, readable(name)),
      residual,
      count,
      said,
    );
    button.addEventListener('click', () => choose(name));
    const bin = element(
      'button',
      { type: 'button', class: 'remove', 'aria-label': `Remove ${readable(name)} here`, title: 'Remove (Delete)' },
      icon('close'),
    );
    bin.addEventListener('click', () => remove(name));
    return { item: element('li', {}, button, bin), button, bin, dots, residual, said };
  });
  return {
    element: element('ol', { class: 'points', 'aria-label': 'Points' }, ...rows.map(({ item }) => item)),
    show(states, active) {
      states.forEach(({ name, here, count, residual, off }, i) => {
        const row = rows[i]!;
        const isActive = name === active;
        if (isActive && row.button.getAttribute('aria-current') === null)
          row.item.scrollIntoView({ block: 'nearest' });
        setAttribute(row.button, 'aria-current', isActive && 'step');
        row.item.dataset['here'] = String(here);
        row.item.dataset['off'] = String(off);
        row.bin.hidden = !here;
        row.dots.forEach((dot, k) => setAttribute(dot, 'class', k < count && 'full'));
        setText(row.residual, residual === null ? '' : `${residual.toFixed(1)} px`);
        setText(
          row.said,
          asked > 0 ? `, in ${count} of ${asked} photographs${here ? ', placed here' : ''}` : here ? ', placed' : '',
        );
      });
    },
  };
}
