// Marks, guesses and lines of sight, drawn over the picture.
import type { Pixel } from '../types/task';
import type { Spot } from './pane';

export interface Shown {
  readonly spot: Spot;
  readonly label: string;
  readonly active: boolean;
  /** Far from where the other photographs put it. */
  readonly off: boolean;
}

const DARK = 'rgb(0 0 0 / 75%)';
const LIGHT = '#fff';
const ACTIVE = '#ffb020';
const OFF = '#ff6a5e';
const GUESS = '#58e0ff';
const RING = 6; // CSS pixels

type Context = CanvasRenderingContext2D;

/** A ring that leaves free what it is about, and a dot in its middle. */
export function drawMark(context: Context, { spot, label, active, off }: Shown): void {
  const colour = off ? OFF : active ? ACTIVE : LIGHT;
  context.globalAlpha = spot.hidden ? 0.35 : 1;
  const radius = active ? RING + 2 : RING;
  outlined(context, colour, active ? 2 : 1.6, () => {
    context.beginPath();
    context.arc(spot.x, spot.y, radius, 0, 2 * Math.PI);
  });
  dot(context, spot.x, spot.y, colour);
  if (label) write(context, label, spot.x + radius + 5, spot.y, colour);
  context.globalAlpha = 1;
}

/** Where other photographs say that a point is. */
export function drawGuess(context: Context, { x, y }: Pick<Spot, 'x' | 'y'>, label: string): void {
  outlined(context, GUESS, 1.6, () => {
    context.beginPath();
    for (const [a, b] of [[-1, -1], [1, -1], [1, 1], [-1, 1]] as const) {
      context.moveTo(x + 4 * a, y + 4 * b);
      context.lineTo(x + 10 * a, y + 10 * b);
    }
  });
  if (label) write(context, label, x + 13, y - 9, GUESS);
}

export function drawLine(context: Context, points: readonly Pixel[], first: string): void {
  if (points.length < 2) return;
  outlined(context, GUESS, 1.3, () => {
    context.beginPath();
    points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  });
  const middle = points[points.length >> 1]!;
  if (first) write(context, first, middle[0] + 8, middle[1] - 8, GUESS);
}

/** The vertex that a click would find. */
export function drawHover(context: Context, { x, y }: Spot): void {
  dot(context, x, y, ACTIVE);
}

/** Where a point goes when Enter is pressed. */
export function drawCross(context: Context, x: number, y: number, reach: number, gap: number): void {
  outlined(context, LIGHT, 1, () => {
    context.beginPath();
    for (const [a, b] of [[1, 0], [-1, 0], [0, 1], [0, -1]] as const) {
      context.moveTo(x + gap * a, y + gap * b);
      context.lineTo(x + reach * a, y + reach * b);
    }
  });
}

/** Light and dark on top of each other: seen on skin, hair and cloth. */
function outlined(context: Context, colour: string, width: number, path: () => void): void {
  for (const [style, wide] of [[DARK, width + 2], [colour, width]] as const) {
    context.strokeStyle = style;
    context.lineWidth = wide;
    context.lineJoin = 'round';
    path();
    context.stroke();
  }
}

function dot(context: Context, x: number, y: number, colour: string): void {
  for (const [style, radius] of [[DARK, 2.4], [colour, 1.4]] as const) {
    context.fillStyle = style;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fill();
  }
}

function write(context: Context, words: string, x: number, y: number, colour: string): void {
  context.font = '600 12px system-ui, sans-serif';
  context.textBaseline = 'middle';
  context.lineJoin = 'round';
  context.lineWidth = 3.5;
  context.strokeStyle = DARK;
  context.strokeText(words, x, y);
  context.fillStyle = colour;
  context.fillText(words, x, y);
}
