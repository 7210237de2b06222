// All targets with the method that each has: one look at what a rig is made of.
import { element, setAttribute } from '../../shared/element';
import type { Row } from './bench';
import { shortly, sizeOf } from './figures';

export interface TargetTable {
  readonly element: HTMLElement;
  /** @param made the path by what was chosen for a target, once it is known */
  show(
    rows: readonly Row[],
    chosen: Readonly<Record<string, string>>,
    made: (target: string) => Row | undefined,
    target: string,
  ): void;
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
    show(rows, chosen, made, target) {
      const costs = rows.map((row) => (row.name in chosen ? made(row.name) : row));
      const key = JSON.stringify([rows, chosen, costs]);
      if (key !== drawn) {
        drawn = key;
        body.replaceChildren(
          ...rows.map((row, i) => lineOf(row, costs[i], chosen[row.name], select)),
        );
      }
      for (const line of body.rows) {
        const own = line.dataset.target === target;
        setAttribute(line, 'data-selected', own);
        setAttribute(line.querySelector('button')!, 'aria-pressed', String(own));
      }
    },
  };
}

/** @param costs the row whose path would be written; none while it is being made */
function lineOf(
  row: Row,
  costs: Row | undefined,
  chosen: string | undefined,
  select: (target: string) => void,
) {
  const button = element('button', { type: 'button' }, row.name);
  button.addEventListener('click', () => select(row.name));
  const method = chosen === undefined ? shortly(row.method) : `→ ${chosen || 'none of its own'}`;
  return element(
    'tr',
    { 'data-target': row.name, 'data-chosen': chosen !== undefined },
    element('th', { scope: 'row' }, button),
    element('td', { title: (costs ?? row).method }, method),
    element('td', {}, costs ? String(costs.extra || '–') : '…'),
    element('td', {}, costs ? sizeOf(costs.bytes) : '…'),
  );
}
