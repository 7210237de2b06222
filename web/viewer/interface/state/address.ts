// A view as words of an address, which people can read: `view=jawOpen:0.7&t=0.5&camera=side`.
import type { Place, View } from '../../types/stage';
import type { ViewState } from '../../types/state';
import { INITIAL } from './initial';

/** What is seen, without what people keep beside it. */
const FIELDS = [
  ...['t', 'clip', 'clipTime', 'arrangement', 'shown', 'swipe', 'against', 'heat', 'heatTop'],
  ...['ghost', 'onion', 'orbits', 'picked', 'wireframe', 'loops', 'shading', 'light', 'mirror'],
  ...['timing', 'repeat', 'seconds', 'range', 'speed', 'headTurns'],
] as (keyof ViewState)[];
// Of what kind those are that may be null.
const NUMBERS: readonly (keyof ViewState)[] = ['heatTop'];
const LISTS: readonly (keyof ViewState)[] = ['range'];
const VIEWS: readonly string[] = ['front', 'three-quarter', 'side', 'below'] satisfies View[];

type Weights = ViewState['weights'];

export interface Seen {
  readonly patch: Partial<ViewState>;
  readonly camera: View | Place | null;
}

/** What of a view differs from how the page starts, behind the weights, which always stand there. */
export function written(state: ViewState, start: ViewState, camera: View | Place): string {
  const words = FIELDS.filter((field) => textOf(state[field]) !== textOf(start[field])).map(
    (field) => `${field}=${textOf(state[field])}`,
  );
  if (camera !== 'front') words.push(`camera=${textOf(camera)}`);
  return [`view=${weightsText(state.weights)}`, ...words].join('&');
}

/**
 * The view in the fragment of an address, null where there is none.
 *
 * @throws Error with a sentence for people
 */
export function readView(fragment: string): Seen | null {
  const text = fragment.replace(/^#/, '');
  if (!text.startsWith('view=')) return null;
  const words = text.split('&').map((word): [string, string] => {
    const [, field = '', value = ''] = /^([^=]*)=?(.*)$/s.exec(word)!;
    return [field, value];
  });
  const found: Record<string, unknown> = {};
  let camera: Seen['camera'] = null;
  try {
    for (const [field, value] of words) {
      if (field === 'view') found['weights'] = weightsIn(value);
      else if (field === 'camera') camera = cameraIn(value);
      else found[field] = valueOf(field as keyof ViewState, value);
    }
  } catch {
    throw new Error('The link to this view is damaged, so the page starts without it: copy it again.');
  }
  return { patch: found as Partial<ViewState>, camera };
}

/** The fields of a view as they are in a state. */
export function viewOf(state: ViewState): Partial<ViewState> {
  const fields: (keyof ViewState)[] = ['weights', ...FIELDS];
  return Object.fromEntries(fields.map((field) => [field, state[field]]));
}

function weightsText(weights: Weights): string {
  return Object.entries(weights)
    .map(([slider, weight]) => `${encodeURIComponent(slider)}:${short(weight)}`)
    .join();
}

function weightsIn(text: string): Weights {
  const pairs = text.split(',').filter(Boolean).map((pair) => {
    const [, slider = '', weight = ''] = /^(.*):(.*)$/.exec(decodeURIComponent(pair))!;
    return [slider, Number(weight)] as const;
  });
  return Object.fromEntries(pairs);
}

function textOf(value: unknown): string {
  if (Array.isArray(value)) return value.map(textOf).join();
  if (typeof value === 'number') return short(value);
  if (typeof value === 'boolean') return value ? '1' : '0';
  return value === null ? '' : encodeURIComponent(String(value));
}

function valueOf(field: keyof ViewState, text: string): unknown {
  const like = INITIAL[field];
  if (like === null && text === '') return null;
  if (Array.isArray(like) || LISTS.includes(field)) {
    return text.split(',').filter(Boolean).map(Number);
  }
  if (typeof like === 'number' || NUMBERS.includes(field)) return Number(text);
  if (typeof like === 'boolean') return { '0': false, '1': true }[text] ?? text;
  return decodeURIComponent(text);
}

function cameraIn(text: string): View | Place {
  if (VIEWS.includes(text)) return text as View;
  const place = text.split(',').map(Number);
  if (place.length !== 6 || !place.every(Number.isFinite) || !(place[2]! > 0)) throw new Error(text);
  return place as unknown as Place;
}

function short(value: number): string {
  return String(Number(value.toFixed(4)));
}
