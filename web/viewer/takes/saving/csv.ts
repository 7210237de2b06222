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
  const times = clip.recorded?.times ?? Float64Array.from(clip.times);
  const lines = [[...headOf(clip, names, columns, times), ...names].map(quoted).join(',')];
  for (let i = 0; i < times.length; i += 1) {
    const first = timecodes.length > 0 ? [timecodes[i]!, names.length] : [shortest(times[i]!)];
    lines.push([...first, ...columns.map((column) => shortest(column[i]!))].join(','));
  }
  return new Blob([`${lines.join('\n')}\n`], { type: 'text/csv' });
}

function headOf(
  clip: Clip,
  names: readonly string[],
  columns: Columns['columns'],
  times: Float64Array,
) {
  if (clip.recorded?.timecodes.length) return ['Timecode', 'BlendShapeCount'];
  const table = Float64Array.from(
    { length: times.length * names.length },
    (_, i) => columns[i % names.length]![Math.floor(i / names.length)]!,
  );
  return [timeColumn(names, times, table)];
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
    for (let i = 0; i < frames; i += 1)
      column[i]! += changes.reduce((sum, [, by]) => sum + by[i]! / changes.length, 0);
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

/** The shortest text that single precision reads as this number; more digits where it has more. */
function shortest(value: number): string {
  if (Math.fround(value) !== value) return String(value);
  for (let digits = 6; digits < 9; digits += 1) {
    const text = Number(value.toPrecision(digits));
    if (Math.fround(text) === value) return String(text);
  }
  return String(value);
}

function quoted(name: string | number): string {
  const text = String(name);
  return /[",\r\n;\t]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
}
