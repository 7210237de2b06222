// What two paths to one target cost and how far they are from others, side by side.
import { lengthAndShare } from '../interface/names/lengths';
import { element } from '../../shared/element';
import type { Row } from './bench';

export function figuresOf(now: Row, other: Row | null, unit: string, diameter: number): HTMLElement {
  const rows = other ? [now, other] : [now];
  // Broken before the share, where there is no room for both.
  const far = (value: number) =>
    value > 0
      ? lengthAndShare(value, unit, diameter).replaceAll(' ', '\u00a0').replace('\u00a0(', ' (')
      : '–';
  const line = (words: string, value: (row: Row) => string) =>
    element(
      'tr',
      {},
      element('th', { scope: 'row' }, words),
      ...rows.map((row) => element('td', {}, value(row))),
    );
  return element(
    'table',
    { class: 'figures-table' },
    element(
      'thead',
      {},
      element(
        'tr',
        {},
        element('td', {}),
        element('th', { scope: 'col' }, 'Now'),
        other && element('th', { scope: 'col' }, 'Chosen'),
      ),
    ),
    element(
      'tbody',
      {},
      line('Path', ({ method }) => shortly(method)),
      line('Extra targets', ({ extra }) => String(extra)),
      line('Size in a file', ({ bytes }) => sizeOf(bytes)),
      line('Largest off straight', ({ largest }) => far(largest)),
      line('Mean off straight', ({ mean }) => far(mean)),
      now.between && line('Largest off scans', ({ between }) => far(between?.[0] ?? 0)),
    ),
  );
}

/** `auto: turned` of why it did so. */
export function shortly(method: string): string {
  return method.split(',')[0] ?? method;
}

export function sizeOf(bytes: number): string {
  if (bytes === 0) return '–';
  return bytes < 1e5 ? `${(bytes / 1e3).toFixed(1)} kB` : `${(bytes / 1e6).toFixed(2)} MB`;
}
