// Colours that say something: of distances, of models and of loops.

/** Of model number i: modelColours[i % length]. Told apart by most people with any colour sense. */
export const modelColours: readonly string[] = [
  '#2f8fe0',
  '#f0862a',
  '#23a776',
  '#c95fb8',
  '#b59410',
  '#7d74e0',
];

/** Of loop number i. */
export const loopColours: readonly string[] = [
  '#f2b134',
  '#3aa6f0',
  '#ef6a5b',
  '#4cc38a',
  '#b78af0',
  '#e86fb0',
  '#38c3c9',
  '#a8c545',
];

/**
 * The heat map, from no distance to the largest, evenly apart: magma of matplotlib (CC0) backwards,
 * as in every picture and figure of elastomorph. No distance is pale; equal steps look equal, in
 * grey and for any colour sense too.
 */
const HEAT: readonly string[] = [
  '#fcfdbf', '#fceeb0', '#fde0a1', '#fed194', '#fec287', '#feb47b',
  '#fea571', '#fd9668', '#fb8761', '#f9785d', '#f4695c', '#ee5b5e',
  '#e55064', '#db476a', '#cf4070', '#c23b75', '#b5367a', '#a8327d',
  '#9b2e7f', '#8e2a81', '#812581', '#752181', '#681c81', '#5c167f',
  '#4f127b', '#420f75', '#341069', '#271258', '#1c1044', '#120d31',
  '#090720', '#03030f', '#000004',
];

/** `n` colours of the heat map as #rrggbb, from no distance to the largest. */
export function heatColours(n: number): string[] {
  return Array.from({ length: n }, (_, i) => hex(heatColour(n > 1 ? i / (n - 1) : 0)));
}

/** Red, green and blue for screens, 0 to 1, at a share of the scale. */
export function heatColour(share: number): [number, number, number] {
  const place = Math.min(Math.max(share, 0), 1) * (HEAT.length - 1);
  const i = Math.min(Math.floor(place), HEAT.length - 2);
  const [from, to] = [channels(HEAT[i]!), channels(HEAT[i + 1]!)];
  const at = (channel: 0 | 1 | 2) => from[channel] + (place - i) * (to[channel] - from[channel]);
  return [at(0), at(1), at(2)];
}

function channels(colour: string): [number, number, number] {
  const number = Number.parseInt(colour.slice(1), 16);
  return [(number >> 16) / 255, ((number >> 8) & 255) / 255, (number & 255) / 255];
}

function hex(rgb: readonly number[]): string {
  return `#${rgb
    .map((c) =>
      Math.round(255 * c)
        .toString(16)
        .padStart(2, '0'),
    )
    .join('')}`;
}
