// A take as text in columns: as it was recorded, with what was edited.
import type { Clip } from '../../types/model';
import { timeColumn } from '../csv/columns';
import { recordingOf } from '../recording';

/**
 * A table that Python and this page read back. A take of Live Link Face stays one: its timecodes,
 * and angles, and weights that drive nothing, as they were.
 */
export function takeAsCsv(clip: Clip): Blob {
  const { names, times, weights, timecodes } = recordingOf(clip);
  const ofPhone = timecodes.length > 0;
  const head = ofPhone ? ['Timecode', 'BlendShapeCount'] : [timeColumn(names, times, weights)];
  const lines = [[...head, ...names].map(quoted).join(',')];
  times.forEach((time, i) => {
    const first = ofPhone ? [timecodes[i]!, names.length] : [time];
    lines.push([...first, ...weights.subarray(i * names.length, (i + 1) * names.length)].join(','));
  });
  return new Blob([`${lines.join('\n')}\n`], { type: 'text/csv' });
}

function quoted(name: string): string {
  return /[",\r\n;\t]/.test(name) ? `"${name.replaceAll('"', '""')}"` : name;
}
