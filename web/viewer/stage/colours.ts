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

/** Lightness, chroma and hue (degrees) of Oklch along the scale. */
const PATH: readonly (readonly [number, number, number])[] = [
  [0.4, 0.12, 285],
  [0.51, 0.115, 257],
  [0.62, 0.1, 218],
  [0.73, 0.125, 170],
  [0.84, 0.165, 128],
  [0.95, 0.17, 103],
];

/**
 * `n` colours of the heat map as #rrggbb, from no distance to the largest. Equal steps look equal:
 * the lightness of Oklab rises evenly, so that the scale holds in grey and for any colour sense.
 */
export function heatColours(n: number): string[] {
  return Array.from({ length: n }, (_, i) => hex(heatColour(n > 1 ? i / (n - 1) : 0)));
}

/** Red, green and blue for screens, 0 to 1, at a share of the scale. */
export function heatColour(share: number): [number, number, number] {
  const place = Math.min(Math.max(share, 0), 1) * (PATH.length - 1);
  const i = Math.min(Math.floor(place), PATH.length - 2);
  const [from, to] = [PATH[i]!, PATH[i + 1]!];
  const at = (axis: 0 | 1 | 2) => from[axis] + (place - i) * (to[axis] - from[axis]);
  return fromOklch(at(0), at(1), (at(2) * Math.PI) / 180);
}

/** Oklab (Ottosson, 2020) to sRGB. */
function fromOklch(lightness: number, chroma: number, hue: number): [number, number, number] {
  const [a, b] = [chroma * Math.cos(hue), chroma * Math.sin(hue)];
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    encoded(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    encoded(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    encoded(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s),
  ];
}

function encoded(light: number): number {
  const c = Math.min(Math.max(light, 0), 1);
  return c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055;
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
