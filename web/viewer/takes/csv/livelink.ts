// Takes of Live Link Face: a timecode and the weights of ARKit a frame, as
// elastomorph.io.performance.livelink.
import type { Recording } from '../../types/model';
import { cut, numbers, refuseLine, type Table } from './table';
import { parseTimecode, takeTiming, TimingError, type Timecode, type Timing } from './timecode';

const [TIMECODE, COUNT] = ['timecode', 'blendshapecount'];

export function isLiveLink({ header }: Table): boolean {
  return header.some((column) => column.toLowerCase() === TIMECODE);
}

/** A frame without a face or with the timecode of the one before is left out. */
export function readLiveLink(table: Table): Recording {
  const { name, header, lines } = table;
  const keys = header.map((column) => column.toLowerCase());
  const count = keys.indexOf(COUNT);
  if (count < 0)
    refuseLine(
      name,
      1,
      'there is no column BlendShapeCount. A take of Live Link Face begins with ' +
        'Timecode,BlendShapeCount,EyeBlinkLeft.',
    );
  const clock = keys.indexOf(TIMECODE);
  const columns = [...keys.keys()].filter((i) => i !== clock && i !== count);
  if (columns.length === 0)
    refuseLine(name, 1, 'there are no columns of weights. Export it again.');
  const rows = withWeights(table, count, columns.length);
  const weights = numbers(table, columns, rows);
  const timecodes = rows.map((row) => timecode(table, row, clock));
  const timing = timed(timecodes, (frame) => [name, lines[rows[frame]!]!]);
  const kept = timing.kept.map((i) =>
    weights.subarray(i * columns.length, (i + 1) * columns.length),
  );
  const own = new Float64Array(kept.length * columns.length);
  kept.forEach((row, i) => own.set(row, i * columns.length));
  return {
    names: columns.map((i) => header[i]!),
    times: timing.times,
    weights: own,
    rate: timing.rate,
    timecodes: timing.kept.map((i) => table.rows[rows[i]!]![clock]!.trim()),
  };
}

function timed(
  timecodes: readonly Timecode[],
  placeOf: (frame: number) => [string, number],
): Timing {
  try {
    return takeTiming(timecodes);
  } catch (problem) {
    if (!(problem instanceof TimingError)) throw problem;
    return refuseLine(...placeOf(problem.frame), `${problem.message}.`);
  }
}

/** The rows in which a face was seen. */
function withWeights({ name, rows, lines }: Table, count: number, weights: number): number[] {
  const found: number[] = [];
  rows.forEach((row, i) => {
    const announced = row[count]?.trim() ?? '';
    if (!/^\d+$/.test(announced))
      refuseLine(
        name,
        lines[i]!,
        `BlendShapeCount is "${cut(announced)}", expected the number of weights. Copy the take ` +
          'again, or delete this line.',
      );
    const number = Number(announced);
    if (number === 0 && row.slice(count + 1).every((cell) => !cell.trim())) return;
    if (number > weights)
      refuseLine(
        name,
        lines[i]!,
        `BlendShapeCount announces ${number} weights, but the header names ${weights}. Columns are ` +
          'missing: export the take again.',
      );
    found.push(i);
  });
  if (found.length === 0)
    refuseLine(name, 1, 'there are no frames with weights below the header. Export it again.');
  return found;
}

function timecode({ name, rows, lines }: Table, row: number, column: number): Timecode {
  const text = rows[row]![column] ?? '';
  return (
    parseTimecode(text) ??
    refuseLine(
      name,
      lines[row]!,
      `the timecode is "${cut(text)}", expected HH:MM:SS:FF.fff such as 13:04:31:12.500. Correct it, ` +
        'or delete this line.',
    )
  );
}
