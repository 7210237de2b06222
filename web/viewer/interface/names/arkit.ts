// The 52 expressions of ARKit in Apple's order, and the names other programs give them.

const BOTH = (...stems: string[]) =>
  (['Left', 'Right'] as const).flatMap((side) => stems.map((stem) => stem + side));
const PAIRS = (...stems: string[]) => stems.flatMap((stem) => [`${stem}Left`, `${stem}Right`]);

export const ARKIT: readonly string[] = [
  ...BOTH(
    ...['eyeBlink', 'eyeLookDown', 'eyeLookIn', 'eyeLookOut', 'eyeLookUp'],
    ...['eyeSquint', 'eyeWide'],
  ),
  ...['jawForward', 'jawLeft', 'jawRight', 'jawOpen'],
  ...['mouthClose', 'mouthFunnel', 'mouthPucker', 'mouthLeft', 'mouthRight'],
  ...PAIRS('mouthSmile', 'mouthFrown', 'mouthDimple', 'mouthStretch'),
  ...['mouthRollLower', 'mouthRollUpper', 'mouthShrugLower', 'mouthShrugUpper'],
  ...PAIRS('mouthPress', 'mouthLowerDown', 'mouthUpperUp'),
  ...PAIRS('browDown'),
  'browInnerUp',
  ...PAIRS('browOuterUp'),
  'cheekPuff',
  ...PAIRS('cheekSquint'),
  ...PAIRS('noseSneer'),
  'tongueOut',
];

const PLACE = new Map(ARKIT.map((name, place) => [name.toLowerCase(), place]));

export const REGIONS = [
  'Eyes',
  'Brows',
  'Cheeks',
  'Nose',
  'Jaw',
  'Mouth',
  'Tongue',
  'Other',
] as const;
export type Region = (typeof REGIONS)[number];

const WORDS: readonly (readonly [Region, RegExp])[] = [
  ['Brows', /brow/],
  ['Eyes', /eye|lid|pupil|blink|gaze/],
  ['Cheeks', /cheek/],
  ['Nose', /nose|nostril|sneer/],
  ['Tongue', /tongue/],
  ['Jaw', /jaw|chin/],
  ['Mouth', /mouth|lip|smile|frown/],
];

/** Which side of the face a name speaks of, and the name without it. */
export interface Sided {
  readonly stem: string;
  readonly side: 'left' | 'right' | null;
}

/** `eyeBlink_L`, `EyeBlinkLeft`, `eyeBlink.l`, `L_eyeBlink` and `left_eyeBlink` are of one stem. */
export function sided(name: string): Sided {
  // 'upright' is no right half of 'up': the side has its own capital letter or stands apart.
  const end = /^(.*?)(?:[_.\- ]([lrLR]|[Ll]eft|[Rr]ight|LEFT|RIGHT)|(Left|Right))$/.exec(name);
  if (end) return { stem: end[1] ?? '', side: sideOf(end[2] ?? end[3] ?? '') };
  const begin = /^(?:([lLrR])[_.\- ]|([Ll]eft|[Rr]ight)[_.\- ])(.+)$/.exec(name);
  if (begin) return { stem: begin[3] ?? '', side: sideOf(begin[1] ?? begin[2] ?? '') };
  return { stem: name, side: null };
}

function sideOf(word: string): 'left' | 'right' {
  return word.toLowerCase().startsWith('l') ? 'left' : 'right';
}

// Programs put the name of a mesh or node in front: 'Face.jawOpen', 'blendShape1.jawOpen'.
function bare(name: string): string {
  return /^.+[.|:](\w{3,})$/.exec(name)?.[1] ?? name;
}

function letters(text: string): string {
  return text.toLowerCase().replace(/[^a-z0-9]/g, '');
}

/** The place of a name in ARKit's order, halves of one expression side by side; null if unknown. */
export function placeOf(name: string): number | null {
  const { stem, side } = sided(bare(name));
  const whole = PLACE.get(letters(stem) + (side ?? ''));
  if (whole !== undefined) return whole;
  const undivided = PLACE.get(letters(stem));
  return undivided === undefined ? null : undivided + (side === 'right' ? 0.5 : 0);
}

export function regionOf(name: string): Region {
  const text = letters(bare(name));
  const starting = WORDS.find(([, word]) => text.search(word) === 0);
  return (starting ?? WORDS.find(([, word]) => word.test(text)))?.[0] ?? 'Other';
}
