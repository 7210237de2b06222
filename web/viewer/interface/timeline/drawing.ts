// The timeline's pictures: ruler, sound and curves, and over them what moves.
import type { Clip } from '../../types/model';
import { loudness, type Sound } from '../../takes/sound';
import { nearestFrame, type Plot, secondsAt, xOf, yOf } from './sight';

export const RULER = 20;
export const WAVE = 26;

const STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1800, 3600];
const APART = 64; // pixels between two numbers of the ruler, at least
const FLAG = 12; // pixels beside a tick that the flag of an in point takes
const DENSE = 1.5; // frames a pixel above which a curve is drawn as the band it fills
const KEYS_APART = 7; // pixels between frames from which keys are dots

export interface Colours {
  readonly accent: string;
  readonly ground: string;
  readonly line: string;
  readonly muted: string;
  readonly text: string;
}

export type Pen = CanvasRenderingContext2D;

/** Numbers along the top. */
export function drawRuler(pen: Pen, plot: Plot, { line, muted }: Colours): void {
  const [from, to] = plot.sight;
  const wide = pen.measureText(`${to.toFixed(2)} s`).width + FLAG;
  const least = ((to - from) / plot.width) * Math.max(APART, wide);
  const step = STEPS.find((one) => one >= least) ?? STEPS.at(-1)!;
  const digits = step < 0.1 ? 2 : step < 1 ? 1 : 0;
  pen.fillStyle = muted;
  pen.strokeStyle = line;
  pen.lineWidth = 1;
  pen.beginPath();
  for (let i = Math.ceil(from / step); i * step <= to; i += 1) {
    const x = Math.round(xOf(plot, i * step)) + 0.5;
    pen.moveTo(x, RULER - 5);
    pen.lineTo(x, plot.height);
    if (x + wide <= plot.width) pen.fillText(`${(i * step).toFixed(digits)} s`, x + FLAG, 12);
  }
  pen.stroke();
}

/** How loud a sound is that begins at a moment of the take. */
export function drawSound(
  pen: Pen,
  plot: Plot,
  sound: Sound,
  offset: number,
  { muted }: Colours,
): void {
  const middle = RULER + WAVE / 2;
  pen.fillStyle = muted;
  for (let x = 0; x < plot.width; x += 1) {
    const from = secondsAt(plot, x) - offset;
    const loud = loudness(sound, from, secondsAt(plot, x + 1) - offset);
    if (from < 0 || from > sound.seconds) continue;
    const half = Math.max(0.5, (loud * (WAVE - 4)) / 2);
    pen.fillRect(x, middle - half, 1, 2 * half);
  }
}

/** A curve over the part of a take that is in sight. */
export function curveOf(plot: Plot, { times }: Clip, track: Float32Array): Path2D {
  const [from, to] = plot.sight;
  const clip = { times } as Clip;
  const first = Math.max(0, nearestFrame(clip, from) - 1);
  const last = Math.min(times.length - 1, nearestFrame(clip, to) + 1);
  const path = new Path2D();
  if ((last - first) / plot.width <= DENSE) {
    for (let i = first; i <= last; i += 1) path.lineTo(xOf(plot, times[i]!), yOf(plot, track[i]!));
    return path;
  }
  let column = -1;
  let [low, high] = [0, 0];
  const close = () => {
    if (column < 0) return;
    path.lineTo(column, yOf(plot, low));
    path.lineTo(column, yOf(plot, high));
  };
  for (let i = first; i <= last; i += 1) {
    const x = Math.floor(xOf(plot, times[i]!));
    const value = track[i]!;
    if (x === column) {
      if (value < low) low = value;
      if (value > high) high = value;
      continue;
    }
    close();
    [column, low, high] = [x, value, value];
  }
  close();
  return path;
}

/** Everything that stays while a take plays or one of its curves is drawn anew. */
export function drawStill(
  pen: Pen,
  plot: Plot,
  clip: Clip,
  others: readonly string[],
  colours: Colours,
): void {
  drawRuler(pen, plot, colours);
  pen.strokeStyle = colours.muted;
  pen.globalAlpha = others.length > 12 ? 0.35 : 0.6;
  for (const name of others) pen.stroke(curveOf(plot, clip, clip.tracks.get(name)!));
  pen.globalAlpha = 1;
}

/** The chosen curve, with its keys where there is room for them. */
export function drawChosen(
  pen: Pen,
  plot: Plot,
  clip: Clip,
  track: Float32Array,
  { accent }: Colours,
): void {
  pen.strokeStyle = accent;
  pen.fillStyle = accent;
  pen.lineWidth = 1.75;
  pen.stroke(curveOf(plot, clip, track));
  pen.lineWidth = 1;
  const [from, to] = plot.sight.map((seconds) => nearestFrame(clip, seconds));
  if (plot.width / Math.max(1, to! - from!) < KEYS_APART) return;
  for (let i = from!; i <= to!; i += 1) {
    pen.beginPath();
    pen.arc(xOf(plot, clip.times[i]!), yOf(plot, track[i]!), 2.5, 0, 2 * Math.PI);
    pen.fill();
  }
}

/** The in and the out point, and a veil over the curves that they leave out: numbers stay readable. */
export function drawRange(
  pen: Pen,
  plot: Plot,
  range: readonly [number, number],
  { accent, ground }: Colours,
): void {
  const [start, end] = range.map((seconds) => xOf(plot, seconds));
  pen.fillStyle = ground;
  pen.globalAlpha = 0.6;
  pen.fillRect(0, RULER, Math.max(0, start!), plot.height);
  pen.fillRect(end!, RULER, Math.max(0, plot.width - end!), plot.height);
  pen.globalAlpha = 1;
  pen.fillStyle = accent;
  for (const [x, way] of [
    [start!, 1],
    [end!, -1],
  ] as const) {
    pen.beginPath();
    pen.moveTo(x, 0);
    pen.lineTo(x + 9 * way, 0);
    pen.lineTo(x, RULER);
    pen.fill();
  }
}

/** Where the clock stands. */
export function drawNow(pen: Pen, plot: Plot, seconds: number, { text }: Colours): void {
  const x = xOf(plot, seconds);
  pen.fillStyle = text;
  pen.fillRect(x - 0.75, 0, 1.5, plot.height);
  pen.beginPath();
  pen.arc(x, RULER - 4, 4, 0, 2 * Math.PI);
  pen.fill();
}
