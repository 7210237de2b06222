// In a report: a button over each table that copies it, for sheets and for documents.
import { element, setText } from '../shared/element';
import './link';

const BACK = 2000; // milliseconds until the button says again what it does

for (const table of document.querySelectorAll<HTMLTableElement>('main table')) {
  // Hidden tables are copied from where something points to them.
  const frame = table.closest('.scroll') ?? table;
  frame.before(button(table));
}
for (const place of document.querySelectorAll<HTMLElement>('[data-copies]')) {
  const table = document.getElementById(place.dataset['copies'] ?? '');
  if (table instanceof HTMLTableElement) place.append(button(table));
}

function button(table: HTMLTableElement): HTMLElement {
  const words = 'Copy as table';
  const said = element('span', { role: 'status', class: 'unseen' });
  const made = element('button', { type: 'button', class: 'copy' }, words);
  made.addEventListener('click', async () => {
    const done = (await copied(table)) ? 'Copied' : 'The browser does not let pages copy';
    setText(made, done);
    setText(said, done);
    setTimeout(() => {
      setText(made, words);
      setText(said, '');
    }, BACK);
  });
  return element('div', { class: 'copying' }, made, said);
}

async function copied(table: HTMLTableElement): Promise<boolean> {
  const rows = cells(table);
  try {
    await navigator.clipboard.write([
      new ClipboardItem({ 'text/plain': blob(tabbed(rows), 'text/plain'), 'text/html': blob(html(table, rows), 'text/html') }),
    ]);
    return true;
  } catch {
    // Older browsers, and pages that may not: a text alone, by the way that is left.
    return await navigator.clipboard?.writeText(tabbed(rows)).then(() => true, () => false) ?? false;
  }
}

const blob = (text: string, type: string) => new Blob([text], { type });
const tabbed = (rows: string[][]) => rows.map((row) => row.join('\t')).join('\n');

function html(table: HTMLTableElement, rows: string[][]): string {
  const heads = table.tHead?.rows.length ?? 0;
  const made = element('table');
  rows.forEach((row, i) => {
    const tag = i < heads ? 'th' : 'td';
    made.append(element('tr', {}, ...row.map((text) => element(tag, {}, text))));
  });
  return made.outerHTML;
}

/** The words of each cell, in rows of equal length: what spans several cells stands in the first. */
function cells(table: HTMLTableElement): string[][] {
  const grid: string[][] = [...table.rows].map(() => []);
  [...table.rows].forEach((row, i) => {
    let column = 0;
    for (const cell of row.cells) {
      while (grid[i]![column] !== undefined) column += 1;
      for (let down = 0; down < cell.rowSpan; down += 1) {
        for (let right = 0; right < cell.colSpan; right += 1) {
          const first = down === 0 && right === 0;
          if (grid[i + down]) grid[i + down]![column + right] = first ? words(cell) : '';
        }
      }
    }
  });
  return grid;
}

/** What a cell says, without stars and what is said for those who do not see them. */
function words(cell: HTMLTableCellElement): string {
  const copy = cell.cloneNode(true) as HTMLElement;
  for (const left of copy.querySelectorAll('.unseen, .star')) left.remove();
  return (copy.textContent ?? '').replaceAll(/\s+/g, ' ').trim();
}
