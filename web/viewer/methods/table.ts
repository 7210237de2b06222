// All targets with the method that each has: one look at what a rig is made of.
import { element, setAttribute } from '../../shared/element';
import type { Row } from './bench';
import { shortly, sizeOf } from './figures';

export interface TargetTable {
  readonly element: HTMLElement;
  show(rows: readonly Row[], chosen: Readonly<Record<string, string>>, target: string): void;
}

export function targetTable(select: (target: string) => void): TargetTable {
  const body = element('tbody');
  let drawn = '';
  return {
    element: element(
      'section',
      { class: 'block' },
      element('h2', {}, 'All targets'),
      element(
        'table',
        { class: 'targets-table' },
        element(
          'thead',
          {},
          element(
            'tr',
            {},
            ...['Target', 'Method', 'Extra', 'Size'].map((words) =>
              element('th', { scope: 'col' }, words),
            ),
          ),
        ),
        body,
      ),
    ),
    show(rows, chosen, target) {
      const key = JSON.stringify([rows, chosen]);
      if (key !== drawn) {
        drawn = key;
        body.replaceChildren(...rows.map((row) => lineOf(row, chosen[row.name], select)));
      }
      for (const line of body.rows) {
        const own = line.dataset.target === target;
        setAttribute(line, 'data-selected', own);
        setAttribute(line.querySelector('button')!, 'aria-pressed', String(own));
      }
    },
  };
}

function lineOf(row: Row, chosen: string | undefined, select: (target: string) => void) {
  const button = element('button', { type: 'button' }, row.name);
  button.addEventListener('click', () => select(row.name));
  const method = chosen === undefined ? shortly(row.method) : `→ ${chosen || 'none of its own'}`;
  return element(
    'tr',
    { 'data-target': row.name, 'data-chosen': chosen !== undefined },
    element('th', { scope: 'row' }, button),
    element('td', { title: row.method }, method),
    element('td', {}, row.extra === 0 ? '–' : String(row.extra)),
    element('td', {}, sizeOf(row.bytes)),
  );
}
