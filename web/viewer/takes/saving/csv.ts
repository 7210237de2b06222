// A take as text in columns: as it was recorded, with what was edited.
import type { Clip } from '../../types/model';
import { timeColumn } from '../csv/columns';
import { trackOf } from '../reading';

interface Columns {
  readonly names: readonly string[];
  readonly columns: readonly ArrayLike<number>[];
}

/**
 * A table that Python and this page read back. A take of Live Link Face stays one: its timecodes,
 * and angles, and weights that drive nothing, as they were. Sliders that its own columns cannot say
 * follow in columns of their own names.
 */
export function takeAsCsv(clip: Clip): Blob {
  const { names, columns } = clip.recorded ? recordedColumns(clip) : ownColumns(clip);
  const timecodes = clip.recorded?.timecodes ?? [];
  const times = clip.recorded?.times ?? clip.times;
  const lines = [[...headOf(clip, names, columns, times), ...names].map(quoted).join(',')];
  for (let i = 0; i < times.length; i += 1) {
    const first = timecodes.length > 0 ? [timecodes[i]!, names.length] : [textOf(times, i)];
    lines.push([...first, ...columns.map((column) => textOf(column, i))].join(','));
  }
  return new Blob([`${lines.join('\n')}\n`], { type: 'text/csv' });
}

function headOf(
  clip: Clip,
  names: readonly string[],
  columns: Columns['columns'],
  times: ArrayLike<number>,
) {
  if (clip.recorded?.timecodes.length) return ['Timecode', 'BlendShapeCount'];
  const table = Float64Array.from(
    { length: times.length * names.length },
    (_, i) => columns[i % names.length]![Math.floor(i / names.length)]!,
  );
  return [timeColumn(names, Float64Array.from(times), table)];
}

function ownColumns({ tracks }: Clip): Columns {
  return { names: [...tracks.keys()], columns: [...tracks.values()] };
}

function recordedColumns({ recorded, tracks, times }: Clip): Columns {
  const { names, weights, drives } = recorded!;
  const frames = times.length;
  const columns = names.map((_, j) =>
    Float64Array.from({ length: frames }, (_, i) => weights[i * names.length + j]!),
  );
  const moved = new Map(
    [...tracks].map(([slider, track]) => {
      const before = trackOf(names, weights, frames, drives.get(slider) ?? []);
      return [slider, track.map((value, i) => value - before[i]!)] as const;
    }),
  );
  names.forEach((name, j) => {
    const changes = [...moved].filter(([slider]) => drives.get(slider)?.includes(name));
    const column = columns[j]!;
    for (let i = 0; i < frames; i += 1) {
      const by = changes.reduce((sum, [, change]) => sum + change[i]! / changes.length, 0);
      if (by !== 0) column[i] = shortest(column[i]! + by);
    }
  });
  const table = Float64Array.from(
    { length: frames * names.length },
    (_, i) => columns[i % names.length]![Math.floor(i / names.length)]!,
  );
  const found: { names: string[]; columns: ArrayLike<number>[] } = { names: [...names], columns };
  for (const [slider, track] of tracks) {
    const back = trackOf(names, table, frames, drives.get(slider) ?? []);
    if (names.includes(slider) || track.every((value, i) => Math.abs(value - back[i]!) < 1e-6))
      continue;
    found.names.push(slider);
    found.columns.push(track);
  }
  return found;
}

/** A number as it is, or of single precision the shortest one that stands for it. */
function textOf(numbers: ArrayLike<number>, i: number): string {
  const value = numbers[i]!;
  return String(numbers instanceof Float32Array ? shortest(value) : value);
}

function shortest(value: number): number {
  const single = Math.fround(value);
  for (let digits = 6; digits < 9; digits += 1) {
    const text = Number(single.toPrecision(digits));
    if (Math.fround(text) === single) return text;
  }
  return single;
}

function quoted(name: string | number): string {
  const text = String(name);
  return /[",\r\n;\t]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
