// Poses as text: as files and the clipboard hold them, and as `elastomorph.read_poses` reads them.
import { numberOf } from '../../../shared/named';
import type { NamedPose } from '../../types/state';
import { numbers, readTable } from '../../takes/csv/table';
import { cleanName, type Poses } from './list';

const FORMAT = 'elastomorph poses';
const VERSION = 1;
const MANY = 10_000; // poses in one text
const EXPECTED = 'expected {"poses": [{"name": "Smile", "weights": {"mouthSmileLeft": 0.7}}]}';

/** JSON with a line for each pose. */
export function asJson(poses: Poses): string {
  const lines = poses.map((pose) => JSON.stringify({ name: pose.name, weights: pose.weights }));
  const head = `{"format": ${JSON.stringify(FORMAT)}, "version": ${VERSION}, "poses": [`;
  return `${head}\n${lines.join(',\n')}\n]}\n`;
}

/** A table with a row for each pose and a column for each slider that one of them moves. */
export function asTable(poses: Poses, sliders: readonly string[]): string {
  const moved = sliders.filter((slider) => poses.some(({ weights }) => numberOf(weights, slider)));
  const rows = poses.map(({ name, weights }) => [
    name,
    ...moved.map((slider) => String(numberOf(weights, slider))),
  ]);
  return [['pose', ...moved], ...rows].map((row) => `${row.map(cell).join(',')}\n`).join('');
}

/** Whether a text that is pasted may be poses, so that others can have it where it is not. */
export function looksLikePoses(text: string): boolean {
  return /^\s*\{/.test(text) || isTable(text);
}

/** The poses in a text, JSON or a table; the same errors. */
export function fromText(source: string, text: string): NamedPose[] {
  if (!isTable(text)) return fromJson(source, text);
  return fromTable(source, new TextEncoder().encode(text).buffer);
}

function isTable(text: string): boolean {
  return /^\W{0,4}pose\W/i.test(text) && !/^\s*\{/.test(text);
}

/**
 * The poses in JSON.
 *
 * @param source what the text is called in messages: a file or the clipboard.
 * @throws Error with a sentence for people
 */
function fromJson(source: string, text: string): NamedPose[] {
  let content: unknown;
  try {
    content = JSON.parse(text);
  } catch {
    throw new Error(`${source}: this is no JSON, or only a part of it; ${EXPECTED}.`);
  }
  const found = entries(source, content).map(([name, weights]) => poseOf(source, name, weights));
  if (found.length === 0) throw new Error(`${source}: there are no poses in it; ${EXPECTED}.`);
  return found;
}

/**
 * The poses in a table whose first column is `pose`; empty cells are 0.
 *
 * @throws Error with a sentence for people
 */
function fromTable(source: string, bytes: ArrayBuffer): NamedPose[] {
  const table = readTable(source, bytes);
  const { header, rows } = table;
  if (header[0]!.toLowerCase() !== 'pose')
    throw new Error(`${source}: the first column is ${header[0]}, expected "pose".`);
  if (rows.length === 0) throw new Error(`${source}: there are no poses below the header.`);
  return rows.map((cells, row) => {
    const filled = header.map((_, column) => column).filter((i) => i > 0 && cells[i]?.trim());
    const values = numbers(table, filled, [row]);
    const weights = filled.map((column, i) => [header[column]!, values[i]!] as const);
    return poseOf(source, cells[0], Object.fromEntries(weights));
  });
}

/** A pose of any text and numbers, checked. */
function poseOf(source: string, name: unknown, weights: unknown): NamedPose {
  const clean = typeof name === 'string' ? cleanName(name) : '';
  if (!clean) throw new Error(`${source}: a pose has no name; ${EXPECTED}.`);
  if (!isObject(weights)) throw new Error(`${source}: “${clean}” has no weights; ${EXPECTED}.`);
  for (const [slider, weight] of Object.entries(weights)) {
    if (typeof weight !== 'number' || !Number.isFinite(weight)) {
      const told = JSON.stringify(weight)?.slice(0, 40);
      throw new Error(
        `${source}: the weight of ${slider} in “${clean}” is ${told}, expected a number.`,
      );
    }
  }
  return { name: clean, weights: weights as Record<string, number> };
}

function entries(source: string, content: unknown): [unknown, unknown][] {
  if (!isObject(content)) throw new Error(`${source}: this is no object with poses; ${EXPECTED}.`);
  const { format, version, poses } = content;
  if (!Array.isArray(poses)) {
    if (format !== undefined || version !== undefined)
      throw new Error(`${source}: there is no list of poses; ${EXPECTED}.`);
    return Object.entries(content);
  }
  if ((format ?? FORMAT) !== FORMAT)
    throw new Error(`${source}: the format is ${JSON.stringify(format)}, expected "${FORMAT}".`);
  if ((version ?? VERSION) !== VERSION)
    throw new Error(`${source}: version ${version} of poses is not known to this page.`);
  if (poses.length > MANY)
    throw new Error(`${source}: it holds ${poses.length} poses; at most ${MANY} are opened here.`);
  return poses.map((pose: unknown) =>
    isObject(pose) ? [pose['name'], pose['weights']] : [undefined, undefined],
  );
}

function isObject(value: unknown): value is Record<string, unknown> {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
}

function cell(text: string): string {
  return /[",;\t\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
