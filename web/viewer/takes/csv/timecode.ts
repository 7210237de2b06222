// When each frame of a take was recorded, by its timecodes: as elastomorph.io.performance.timecode.
const LIVE_LINK_BASE = 60;
const MOST_DROPPED = 100_000;
const WHOLE = 0.02;
const DAY = 86_400;

// Numbers in a second of timecode; drop-frame counts the slower second of two.
const BASES = [24, 25, 30, 48, 50, 60, 100, 120, 240];
const NTSC = 1000 / 1001;

const TIMECODE = /^(\d{1,2}):([0-5]?\d):([0-5]?\d)([:;])(\d{1,3})(\.\d*)?$/;

/** Whole seconds since midnight, the frame with its fraction, and whether ; stands before it. */
export interface Timecode {
  readonly second: number;
  readonly frame: number;
  readonly semicolon: boolean;
}

export interface Timing {
  readonly rate: number; // frames a second, nominal
  readonly kept: readonly number[]; // frames that are not the one before again
  readonly times: Float64Array; // seconds since the first, of each that is kept
}

/** A problem at one frame, as half a sentence. */
export class TimingError extends Error {
  constructor(
    problem: string,
    readonly frame: number,
  ) {
    super(problem);
  }
}

export function parseTimecode(text: string): Timecode | null {
  const found = TIMECODE.exec(text.trim());
  if (!found || Number(found[1]) > 23) return null;
  const second = (Number(found[1]) * 60 + Number(found[2])) * 60 + Number(found[3]);
  const fraction = found[6] && found[6] !== '.' ? Number(`0${found[6]}`) : 0;
  return { second, frame: Number(found[5]) + fraction, semicolon: found[4] === ';' };
}

/** Rate and times of a take; drop-frame is taken for granted where its numbering shows. */
export function takeTiming(timecodes: readonly Timecode[]): Timing {
  const base = baseOf(timecodes);
  const top = timecodes.findIndex(({ frame }) => frame >= base);
  if (top >= 0)
    throw new TimingError(
      `the frame number ${timecodes[top]!.frame} is beyond ${base} frames a second; expected ` +
        'HH:MM:SS:FF.fff with FF below the frames in a second',
      top,
    );
  const drop = dropsNumbers(base, timecodes);
  const rate = drop ? base * NTSC : base;
  const leftOut = drop ? base / 15 : 0;
  const day = base * DAY - leftOut * (1440 - 144);
  let midnights = 0;
  let before = -Infinity;
  const count = timecodes.map(({ second, frame }) => {
    const minutes = Math.floor(second / 60);
    const own = second * base - leftOut * (minutes - Math.floor(minutes / 10)) + frame;
    if (own - before < -day / 2) midnights += 1;
    before = own;
    return own + midnights * day;
  });
  const back = count.findIndex((own, i) => i > 0 && own < count[i - 1]!);
  if (back >= 0)
    throw new TimingError(
      'the timecode goes back; a take must be in the order of recording, so split the file where ' +
        'another take begins',
      back,
    );
  const kept = [...count.keys()].filter((i) => i === 0 || count[i]! > count[i - 1]!);
  const steps = kept.slice(1).map((i, k) => count[i]! - count[kept[k]!]!);
  const step = steps.length > 0 ? wholeStep(lowerMedian(steps)) : 1;
  requireOneTake(steps, step, kept);
  return {
    rate: rate / step,
    kept,
    times: Float64Array.from(kept, (i) => (count[i]! - count[0]!) / rate),
  };
}

function requireOneTake(steps: readonly number[], step: number, kept: readonly number[]): void {
  const absent = steps.map((own) => Math.max(Math.round(own / step) - 1, 0));
  if (absent.reduce((sum, count) => sum + count, 0) <= MOST_DROPPED) return;
  const most = absent.reduce((a, b) => Math.max(a, b), 0);
  throw new TimingError(
    `a gap of ${most.toLocaleString('en')} frames comes before this one; that is two takes, so split ` +
      'the file here',
    kept[absent.indexOf(most) + 1]!,
  );
}

/** Numbers in a second: where a second ends, those that it had. */
function baseOf(timecodes: readonly Timecode[]): number {
  const top = timecodes.reduce((most, { frame }) => Math.max(most, frame), 0);
  const possible = BASES.filter((base) => base > Math.trunc(top));
  if (possible.length === 0)
    throw new TimingError(
      `the frame number ${top} is higher than any rate has; expected HH:MM:SS:FF.fff with FF below ` +
        'the frames in a second (not milliseconds)',
      timecodes.findIndex(({ frame }) => frame === top),
    );
  const within: number[] = [];
  const rolls: number[] = [];
  timecodes.slice(1).forEach(({ second, frame }, i) => {
    const ahead = (second - timecodes[i]!.second + DAY) % DAY;
    const step = frame - timecodes[i]!.frame;
    if (ahead === 0 && step > 0) within.push(step);
    if (ahead === 1) rolls.push(-step);
  });
  if (within.length === 0 || rolls.length === 0)
    return Math.trunc(top) < LIVE_LINK_BASE ? LIVE_LINK_BASE : possible[0]!;
  const estimate = median(rolls) + lowerMedian(within);
  const off = (base: number) => Math.abs(base - estimate);
  return possible.reduce((best, base) => (off(base) < off(best) ? base : best));
}

/** Whether the numbering is drop-frame, by its sign or by its jumps at full minutes. */
function dropsNumbers(base: number, timecodes: readonly Timecode[]): boolean {
  if (![30, 60, 120].includes(base)) return false;
  const leftOut = base / 15;
  const short = (second: number) => second % 60 === 0 && Math.floor(second / 60) % 10 !== 0;
  if (timecodes.some(({ second, frame }) => short(second) && frame < leftOut)) return false;
  if (timecodes.some(({ semicolon }) => semicolon)) return true;
  const steps = timecodes.slice(1).map((own, i) => {
    const last = timecodes[i]!;
    return {
      step: (own.second - last.second) * base + own.frame - last.frame,
      turns: short(own.second) && own.second - last.second === 1,
    };
  });
  const turns = steps.filter((one) => one.turns);
  if (turns.length === 0) return false;
  const usual = lowerMedian(steps.map(({ step }) => step).filter((step) => step > 0));
  return turns.every(({ step }) => Math.abs(step - usual - leftOut) < 0.5);
}

/** Numbers from frame to frame, whole where they nearly are (or one part of a whole). */
function wholeStep(step: number): number {
  const near = [Math.round(step), 1 / Math.max(Math.round(1 / step), 1)];
  return near.find((whole) => whole > 0 && Math.abs(step - whole) < WHOLE * whole) ?? step;
}

/** The median: of two in the middle their mean. */
export function median(values: ArrayLike<number>): number {
  const sorted = Float64Array.from(values).sort();
  const half = sorted.length / 2;
  return (sorted[Math.ceil(half) - 1]! + sorted[Math.floor(half)]!) / 2;
}

/** The median, of two in the middle the lower one: a gap is never usual. */
function lowerMedian(values: readonly number[]): number {
  return Float64Array.from(values).sort()[(values.length - 1) >> 1]!;
}
