// What the parts of a head look like, told from the names their author gave them.

export type PartKind =
  | 'skin'
  | 'lips'
  | 'brow'
  | 'lash'
  | 'hair'
  | 'sclera'
  | 'iris'
  | 'pupil'
  | 'teeth'
  | 'gum'
  | 'tongue'
  | 'mouth'
  | 'nostril'
  | 'hidden';

interface Look {
  readonly colour: readonly [number, number, number]; // sRGB, 0 to 1
  readonly shine: number;
}

export const LOOKS: Readonly<Record<PartKind, Look>> = {
  skin: { colour: [0.83, 0.68, 0.6], shine: 0.32 },
  lips: { colour: [0.74, 0.47, 0.44], shine: 0.5 },
  brow: { colour: [0.36, 0.26, 0.21], shine: 0.12 },
  lash: { colour: [0.24, 0.18, 0.16], shine: 0.1 },
  hair: { colour: [0.33, 0.25, 0.2], shine: 0.3 },
  sclera: { colour: [0.93, 0.92, 0.9], shine: 1 },
  iris: { colour: [0.38, 0.46, 0.5], shine: 1 },
  pupil: { colour: [0.05, 0.05, 0.06], shine: 1 },
  teeth: { colour: [0.93, 0.9, 0.85], shine: 0.8 },
  gum: { colour: [0.72, 0.42, 0.42], shine: 0.6 },
  tongue: { colour: [0.74, 0.43, 0.43], shine: 0.5 },
  mouth: { colour: [0.42, 0.21, 0.21], shine: 0.15 },
  nostril: { colour: [0.44, 0.27, 0.24], shine: 0.15 },
  hidden: { colour: [0.83, 0.68, 0.6], shine: 0 },
};

const SIDE = '(_(l|r|left|right|upper|lower|mesh|geo|mat))*';
// Whole words, the telling ones first: "lacrimal fluid of the eye" is no eye.
const WORDS: readonly (readonly [PartKind, string])[] = [
  [
    'hidden',
    'occlusion|eye_?blend|lacrimal|tears?|tear_?line|meniscus|eye_?shadow|eye_?wet|fluid|cornea',
  ],
  ['pupil', 'pupils?'],
  ['iris', 'iris|irises'],
  ['sclera', 'scleras?|eye_?whites?|eye_?balls?'],
  ['lash', '(eye_?)?lash(es)?'],
  ['brow', '(eye_?)?brows?'],
  ['lips', 'lips?'],
  ['teeth', 'teeth|tooth'],
  ['gum', 'gums?'],
  ['tongue', 'tongue'],
  ['mouth', `mouth(_?(socket|bag|inner|inside|interior|cavity))?${SIDE}$|oral|throat`],
  ['nostril', 'nostrils?'],
  ['hair', 'hair|scalp|beard'],
  ['sclera', `eyes?${SIDE}$`],
];
const PATTERNS = WORDS.map(([kind, words]) => [kind, new RegExp(`(^|_)(${words})(_|$)`)] as const);

/** The part of a head that the name of a material or group speaks of, or else skin. */
export function partOfName(name: string): PartKind {
  const words = name
    .replace(/(?<=[a-z])(?=[A-Z])/g, '_')
    .replace(/[^\p{L}]+/gu, '_')
    .replace(/^_+|_+$/g, '')
    .toLowerCase();
  return PATTERNS.find(([, pattern]) => pattern.test(words))?.[0] ?? 'skin';
}

/** Light from a colour as screens take it. */
export function linear(srgb: readonly number[]): [number, number, number] {
  const decode = (c: number) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  return [decode(srgb[0] ?? 0), decode(srgb[1] ?? 0), decode(srgb[2] ?? 0)];
}
