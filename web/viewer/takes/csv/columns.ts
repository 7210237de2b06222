// Plain columns with a time: as elastomorph.io.performance.columns.
import type { Recording } from '../../types/model';
import { numbers, refuseLine, type Table } from './table';
import { median } from './timecode';

const AS_IT_IS = 'seconds';
const MILLISECONDS = ['milliseconds', 'ms', 'time_ms', 'time (ms)', 'time [ms]'];
const TIMES = ['time', AS_IT_IS, ...MILLISECONDS];

const [CLOSEST, FARTHEST] = [4, 250]; // milliseconds between frames
const FEWEST_TIMES = 10;
const MOST_IN_FULL = 2;
const [LEAST_PERCENT, MOST_PERCENT] = [10, 200];
const FEWEST_IN_PERCENT = 0.25;
const LATEST = 1e15;

// Turns and places of head and eyes may be in degrees or centimetres beside weights of 1.
const POSE = /^(head|neck|eye).*(yaw|pitch|roll|rot\w*|pos\w*|trans\w*|[xyz])$/i;

const NTSC = 1000 / 1001;
const RATES = [24 * NTSC, 24, 25, 30 * NTSC, 30, 48, 50, 60 * NTSC, 60, 120];
const SAME_RATE = 5e-4;

export function readColumns(table: Table): Recording {
  const { name, header, rows, lines } = table;
  const found = header.flatMap((column, i) => (TIMES.includes(column.toLowerCase()) ? [i] : []));
  if (found.length !== 1)
    refuseLine(
      name,
      1,
      `expected one column "time" in seconds (or a Timecode), found ${found.length}. A take begins ` +
        'for example with time,jawOpen,browInnerUp.',
    );
  const time = found[0]!;
  const columns = [...header.keys()].filter((i) => i !== time);
  if (columns.length === 0)
    refuseLine(name, 1, 'there are no columns of weights. Export it again.');
  if (rows.length === 0)
    refuseLine(name, 1, 'there are no frames below the header. Export it again.');
  const all = [...rows.keys()];
  const times = numbers(table, [time], all);
  const weights = numbers(table, columns, all);
  requireRising(name, times, lines);
  const names = columns.map((i) => header[i]!);
  try {
    const units = unitsOf(header[time]!, names, times, weights);
    const seconds = times.map((own) => own * units.time);
    const scaled = weights.map((own, i) => own * units.weights[i % names.length]!);
    const read = { names, times: seconds, weights: scaled, rate: rateOf(seconds), timecodes: [] };
    return units.guessed ? { ...read, guessed: units.guessed } : read;
  } catch (problem) {
    refuseLine(name, 1, `${(problem as Error).message}.`);
  }
}

/** Refuses times that no clock has. */
export function requireRising(name: string, times: Float64Array, lines: readonly number[]): void {
  const beyond = times.findIndex((time) => Math.abs(time) > LATEST);
  if (beyond >= 0)
    refuseLine(name, lines[beyond]!, `the time ${times[beyond]} cannot be seconds. Correct it.`);
  const back = times.findIndex((time, i) => i > 0 && time <= times[i - 1]!);
  if (back < 0) return;
  refuseLine(
    name,
    lines[back]!,
    `the time ${times[back]} s does not come after ${times[back - 1]} s. Times must rise: split the ` +
      'file where another take begins.',
  );
}

/** Frames a second: of the whole where times are even, else of most frames. */
export function rateOf(times: Float64Array): number {
  if (times.length < 2) return 30;
  const usual = median(times.subarray(1).map((time, i) => time - times[i]!));
  const mean = (times.at(-1)! - times[0]!) / (times.length - 1);
  const rate = 1 / (Math.abs(mean - usual) < 0.05 * usual ? mean : usual);
  const off = (known: number) => Math.abs(known - rate);
  const nearest = RATES.reduce((best, known) => (off(known) < off(best) ? known : best));
  return off(nearest) <= SAME_RATE * nearest ? nearest : rate;
}

/**
 * What to multiply times and weights with.
 *
 * @throws Error with half a sentence where nothing tells
 */
export function unitsOf(
  column: string,
  names: readonly string[],
  times: Float64Array,
  weights: Float64Array,
): { time: number; weights: readonly number[]; guessed?: string } {
  const inFull = names.map(() => 1);
  if (column.toLowerCase() === AS_IT_IS) return { time: 1, weights: inFull };
  const named = MILLISECONDS.includes(column.toLowerCase());
  const milli = named || inMilliseconds(times);
  const own = names.map((name) => !POSE.test(name));
  const percent = inPercent(names.map((_, j) => (own[j] ? largest(weights, j, names.length) : 0)));
  const guesses = [
    ...(milli && !named ? ['its times are taken for milliseconds'] : []),
    ...(percent ? ['its weights are taken for percent'] : []),
  ];
  return {
    time: milli ? 1e-3 : 1,
    weights: percent ? own.map((is) => (is ? 0.01 : 1)) : inFull,
    guessed: guesses.join(' and '),
  };
}

function inMilliseconds(times: Float64Array): boolean {
  if (times.length < 2) return false;
  const step = median(times.subarray(1).map((time, i) => time - times[i]!));
  if (step < CLOSEST || step > FARTHEST) return false;
  if (times.length >= FEWEST_TIMES) return true;
  throw new Error(
    `the times are ${step} apart, which could be seconds or milliseconds; call their column ` +
      `"${AS_IT_IS}" or "${MILLISECONDS[0]}"`,
  );
}

function inPercent(largests: readonly number[]): boolean {
  const most = Math.max(0, ...largests);
  if (most <= MOST_IN_FULL || most > MOST_PERCENT) return false;
  const moving = largests.filter((one) => one > 0).length;
  const above = largests.filter((one) => one > MOST_IN_FULL).length;
  if (most > LEAST_PERCENT && above >= FEWEST_IN_PERCENT * moving) return true;
  throw new Error(
    `the weights go up to ${most}, which could be percent or not; scale them to 0 to 1, or call the ` +
      `column of times "${AS_IT_IS}" to have all numbers taken as they are`,
  );
}

function largest(weights: Float64Array, column: number, count: number): number {
  let most = 0;
  for (let i = column; i < weights.length; i += count) most = Math.max(most, Math.abs(weights[i]!));
  return most;
}

/** The column of times under which numbers come back as they are. */
export function timeColumn(
  names: readonly string[],
  times: Float64Array,
  weights: Float64Array,
): string {
  try {
    const units = unitsOf('time', names, times, weights);
    return units.time === 1 && units.weights.every((one) => one === 1) ? 'time' : AS_IT_IS;
  } catch {
    return AS_IT_IS;
  }
}
