// Tables of numbers as text in columns, read strictly: as elastomorph.io.performance.table.
import { refuse } from '../../files/container';

const SHOWN = 40;
const NUMBER = /^\s*[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?\s*$/i;
const DECIMAL_COMMA = /^\s*[+-]?\d*,\d+(e[+-]?\d+)?\s*$/i;

/** The cells of a file and the line of each row; empty lines are left out. */
export interface Table {
  readonly name: string; // of the file
  readonly header: readonly string[];
  readonly rows: readonly (readonly string[])[];
  readonly lines: readonly number[];
  readonly decimalComma: boolean;
}

/** Refuses a file for what stands in one of its lines. */
export function refuseLine(name: string, line: number, problem: string): never {
  return refuse(`${name}, line ${line.toLocaleString('en')}`, problem);
}

export function readTable(name: string, bytes: ArrayBuffer): Table {
  const text = decoded(name, bytes);
  const first = /[^\r\n]*/.exec(text.replace(/^[\r\n]+/, ''))![0];
  const separator = separatorOf(first);
  const { rows, lines } = text.includes('"')
    ? quoted(name, text, separator)
    : plain(text, separator);
  const [head, ...below] = rows;
  if (!head) refuse(name, 'the file is empty. Expected a header and a row for each frame.');
  const header = head.map((cell) => cell.trim());
  header.forEach((column, i) => {
    if (!column) refuseLine(name, lines[0]!, `column ${i + 1} of the header has no name. Name it.`);
    if (header.indexOf(column) < i)
      refuseLine(name, lines[0]!, `the header names ${cut(column)} twice. Rename one of them.`);
  });
  const decimalComma =
    separator !== ',' && below.some((row) => row.some((cell) => DECIMAL_COMMA.test(cell)));
  return { name, header, rows: below, lines: lines.slice(1), decimalComma };
}

/** (rows, columns) finite numbers. */
export function numbers(
  table: Table,
  columns: readonly number[],
  rows: readonly number[],
): Float64Array {
  const { name, header, lines, decimalComma } = table;
  const values = new Float64Array(rows.length * columns.length);
  rows.forEach((row, i) => {
    const cells = table.rows[row]!;
    if (cells.length !== header.length) {
      refuseLine(
        name,
        lines[row]!,
        `expected ${header.length} columns as in the header, found ${cells.length}. Copy the take ` +
          'again, or delete this line.',
      );
    }
    columns.forEach((column, j) => {
      const cell = cells[column]!;
      const text = decimalComma && !cell.includes('.') ? cell.replace(',', '.') : cell;
      const mixed = decimalComma && cell.includes('.');
      const value = !mixed && NUMBER.test(text) ? Number(text) : NaN;
      if (!Number.isFinite(value)) {
        const comma = decimalComma ? ' with a decimal comma, as others have' : '';
        refuseLine(
          name,
          lines[row]!,
          `${cut(header[column]!)} is "${cut(cell)}", expected a finite number${comma}. Correct it, ` +
            'or delete this line.',
        );
      }
      values[i * columns.length + j] = value;
    });
  });
  return values;
}

/** A text of the file, short enough for a message. */
export function cut(text: string): string {
  return text.length <= SHOWN ? text : `${text.slice(0, SHOWN)}…`;
}

function decoded(name: string, bytes: ArrayBuffer): string {
  const content = new Uint8Array(bytes);
  const mark = `${content[0]} ${content[1]}`;
  if (mark === '255 254' || mark === '254 255')
    refuseLine(name, 1, 'the text is UTF-16. Save it as UTF-8.');
  let end = content.length;
  while (end > 0 && content[end - 1] === 0) end -= 1; // padding
  const own = content.subarray(0, end);
  const lineOf = (place: number) => own.subarray(0, place).filter((byte) => byte === 10).length + 1;
  const zero = own.indexOf(0);
  if (zero >= 0)
    refuseLine(name, lineOf(zero), 'this is not text: there is a zero byte. Copy it again.');
  try {
    return new TextDecoder('utf-8', { fatal: true }).decode(own);
  } catch {
    refuse(name, 'the text is not UTF-8. Save it as UTF-8.');
  }
}

/** What gives the first line the most columns; commas, if in doubt. */
function separatorOf(first: string): string {
  const [comma, semicolon, tab] = [',', ';', '\t'].map((mark) => first.split(mark).length);
  if (comma! >= semicolon! && comma! >= tab!) return ',';
  return semicolon! >= tab! ? ';' : '\t';
}

function plain(text: string, separator: string) {
  const rows: string[][] = [];
  const lines: number[] = [];
  text.split(/\r\n|\r|\n/).forEach((line, i) => {
    if (line === '') return;
    rows.push(line.split(separator));
    lines.push(i + 1);
  });
  return { rows, lines };
}

/** Cells that may stand in quotation marks, which are doubled within. */
function quoted(name: string, text: string, separator: string) {
  const rows: string[][] = [];
  const lines: number[] = [];
  const cell = new RegExp(
    `(?:"((?:[^"]|"")*)"|([^"${separator}\r\n][^${separator}\r\n]*|))(${separator}|\r\n|\r|\n|$)`,
    'y',
  );
  let row: string[] = [];
  for (let line = 1; cell.lastIndex < text.length || row.length > 0;) {
    const found = cell.exec(text);
    if (!found)
      refuseLine(name, line, 'this is not comma-separated text: a quotation mark is open.');
    line += found[0].split(/\r\n|\r|\n/).length - 1;
    row.push(found[1]?.replaceAll('""', '"') ?? found[2]!);
    if (found[3] === separator) continue;
    if (row.length > 1 || row[0] !== '') {
      rows.push(row);
      lines.push(found[3] === '' ? line : line - 1);
    }
    row = [];
    if (found[3] === '') break;
  }
  return { rows, lines };
}
