// What a change of the state may hold: people type into it from the console and Python writes it.
import type { Clip } from '../../types/model';
import type { NamedPose, ViewState } from '../../types/state';

type Check = (value: unknown, field: string) => unknown;

const FAR = 10; // a weight beyond this is a slip of the keyboard, not an expression

const number =
  (least: number, most: number): Check =>
  (value, field) => {
    if (typeof value !== 'number' || !Number.isFinite(value)) refuse(field, 'a number', value);
    return Math.min(most, Math.max(least, value as number));
  };

const truth: Check = (value, field) =>
  typeof value === 'boolean' ? value : refuse(field, 'true or false', value);

const oneOf =
  (...names: string[]): Check =>
  (value, field) =>
    names.includes(value as string) ? value : refuse(field, `one of ${names.join(', ')}`, value);

const orNull =
  (check: Check): Check =>
  (value, field) =>
    value === null ? null : check(value, field);

const name: Check = (value, field) =>
  typeof value === 'string' ? value : refuse(field, 'a name', value);

const integers: Check = (value, field) => {
  const fits = Array.isArray(value) && value.every((n) => Number.isInteger(n) && n >= 0);
  return fits ? [...new Set(value as number[])] : refuse(field, 'a list of whole numbers', value);
};

/** Numbers by name; those that are 0 are left out. */
const numbersBy =
  (words: string, check: Check): Check =>
  (value, field) => {
    if (typeof value !== 'object' || value === null || Array.isArray(value)) {
      refuse(field, words, value);
    }
    const found = Object.entries(value as object).map(
      ([name, amount]) => [name, check(amount, `${field}.${name}`)] as const,
    );
    return Object.fromEntries(found.filter(([, amount]) => amount !== 0));
  };

const weights = numbersBy('weights by slider, as in { jawOpen: 0.5 }', number(-FAR, FAR));

const names: Check = (value, field) => {
  const fits = Array.isArray(value) && value.every((one) => typeof one === 'string');
  return fits ? [...new Set(value as string[])] : refuse(field, 'a list of names', value);
};

const poses: Check = (value, field) => {
  const fits = (one: unknown): one is NamedPose =>
    typeof (one as NamedPose | null)?.name === 'string' && (one as NamedPose).name !== '';
  if (!Array.isArray(value) || !value.every(fits)) {
    refuse(field, 'poses such as [{ name: "Smile", weights: { jawOpen: 0.5 } }]', value);
  }
  const given = value as NamedPose[];
  const seen = new Set<string>();
  const twice = given.find(({ name }) => seen.size === seen.add(name).size);
  if (twice) refuse(field, 'poses of different names', twice.name);
  return given.map((pose) => ({
    name: pose.name,
    weights: weights(pose.weights, `${field}.${pose.name}`),
  }));
};

/** A performance as it is, or in plain lists as people and Python write it. */
const take = (value: Partial<Clip> | null): Clip | null => {
  if (typeof value?.name !== 'string') return null;
  if (value.times instanceof Float64Array && value.tracks instanceof Map) return value as Clip;
  const clip: Clip = {
    ...(value as Clip),
    times: Float64Array.from(value.times ?? []),
    tracks: new Map(
      Object.entries(value.tracks ?? {}).map(([slider, track]) => [slider, floats(track)]),
    ),
  };
  return isWhole(clip) ? clip : null;
};

/** Whether every curve of a performance has a number at each of its times, which rise. */
export function isWhole({ times, tracks }: Clip): boolean {
  const whole = [...tracks.values()].every(
    (track) => track.length === times.length && track.every(Number.isFinite),
  );
  const rises = times.every(
    (time, i) => Number.isFinite(time) && (i === 0 || time > times[i - 1]!),
  );
  return whole && rises && times.length > 0;
}

const floats = (numbers: ArrayLike<number>) => Float32Array.from(numbers);

const takes: Check = (value, field) => {
  const clips = Array.isArray(value) ? value.map(take) : [null];
  const words = 'performances, as in [{ name, times: [0, 1], tracks: { jawOpen: [0, 1] } }]';
  return clips.every(Boolean) ? clips : refuse(field, words, value);
};

const range: Check = (value, field) => {
  const fits = Array.isArray(value) && value.length === 2 && value.every(Number.isFinite);
  if (!fits) refuse(field, 'two moments in seconds, or null', value);
  return (value as number[]).toSorted((a, b) => a - b);
};

const methods: Check = (value, field) => {
  const fits = typeof value === 'object' && value !== null && !Array.isArray(value);
  return fits && Object.values(value).every((method) => typeof method === 'string')
    ? value
    : refuse(field, "methods by target, as in { jawOpen: 'rotation' }", value);
};

const whole: Check = (value, field) => Math.round(number(0, Infinity)(value, field) as number);

const CHECKS: Record<keyof ViewState, Check> = {
  weights,
  t: number(0, 1),
  correctivesOff: names,
  mirror: truth,
  arrangement: oneOf('single', 'side', 'swipe'),
  shown: integers,
  swipe: number(0, 1),
  ghost: truth,
  onion: (value, field) => Math.round(number(0, 9)(value, field) as number),
  orbits: truth,
  picked: integers,
  grab: truth,
  pins: integers,
  heat: truth,
  against: whole,
  heatTop: orNull(number(1e-7, 1)),
  wireframe: truth,
  loops: truth,
  shading: oneOf('smooth', 'flat'),
  light: oneOf('studio', 'matcap'),
  theme: oneOf('system', 'light', 'dark'),
  playing: truth,
  repeat: oneOf('once', 'loop', 'back and forth'),
  timing: oneOf('linear', 'smoothstep', 'minimum-jerk', 'cosine', 'blink'),
  seconds: number(0.1, 60),
  clip: orNull(name),
  clipTime: number(-1e15, 1e15),
  takes,
  range: orNull(range),
  speed: number(0.1, 2),
  soundOffsets: numbersBy("seconds by performance, as in { 'a take': 0.2 }", number(-1e6, 1e6)),
  live: truth,
  headTurns: truth,
  poses,
  favourites: names,
  folded: names,
  methods,
};

/** The same change with its numbers clamped; throws a RangeError that names the field. */
export function checked(patch: Partial<ViewState>): Partial<ViewState> {
  const entries = Object.entries(patch).map(([field, value]) => {
    const check = CHECKS[field as keyof ViewState];
    if (!Object.hasOwn(CHECKS, field)) {
      throw new RangeError(`'${field}' is not part of the view; there is ${fields()}`);
    }
    return [field, check(value, field)];
  });
  return Object.fromEntries(entries) as Partial<ViewState>;
}

/** As `checked`, but leaves out what cannot be understood and tells of it. */
export function understood(patch: object, tell: (problem: string) => void): Partial<ViewState> {
  let found: Partial<ViewState> = {};
  for (const [field, value] of Object.entries(patch)) {
    try {
      found = { ...found, ...checked({ [field]: value }) };
    } catch (error) {
      tell((error as Error).message);
    }
  }
  return found;
}

function refuse(field: string, expected: string, found: unknown): never {
  throw new RangeError(`'${field}' must be ${expected}; found ${JSON.stringify(found) ?? found}`);
}

function fields(): string {
  return Object.keys(CHECKS).join(', ');
}
