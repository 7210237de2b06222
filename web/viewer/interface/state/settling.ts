// Makes a state agree with the models there are: valid numbers of models, weights of the clip.
import { clipNamed, clipWeights, span } from '../../rig/clips';
import type { Model } from '../../types/model';
import type { Arrangement, ViewState } from '../../types/state';

export function settling(models: () => readonly Model[]): (state: ViewState) => ViewState {
  let before: ViewState | null = null;
  let together: readonly number[] = []; // models last seen with others, for the way back from one
  return (asked) => {
    const all = models();
    // Only where nobody said which models to show.
    const returns = before?.shown === asked.shown && before.arrangement !== asked.arrangement;
    const shown = chosen(asked, all.length, returns ? together : []);
    let state: ViewState = {
      ...asked,
      ...shown,
      against: pairedWith(asked, shown.shown, all.length),
    };
    const vertices = (all[0]?.neutral.length ?? 0) / 3;
    for (const field of ['picked', 'pins'] as const) {
      if (state[field].some((vertex) => vertex >= vertices)) {
        state = { ...state, [field]: state[field].filter((vertex) => vertex < vertices) };
      }
    }
    if (state.arrangement === 'side') together = state.shown;
    before = driven(state, all, before);
    // What plays takes the sliders from the phone.
    if (before.live && (before.playing || before.clip !== null)) before = { ...before, live: false };
    return before;
  };
}

// An unchanged list stays the same object, so that nobody draws for nothing.
function chosen(
  asked: ViewState,
  count: number,
  together: readonly number[],
): Pick<ViewState, 'arrangement' | 'shown'> {
  const arrangement: Arrangement = count < 2 ? 'single' : asked.arrangement;
  const known = (model: number) => model < count;
  const valid = asked.shown.filter(known);
  const most = arrangement === 'single' ? 1 : arrangement === 'swipe' ? 2 : 3;
  const companions = together.filter(known);
  const least = Math.min(most, Math.max(2, companions.length));
  const shown = valid.slice(0, most);
  for (const model of [...companions, ...Array(count).keys()]) {
    if (shown.length < least && !shown.includes(model)) shown.push(model);
  }
  const same =
    shown.length === asked.shown.length && shown.every((model, i) => model === asked.shown[i]);
  return { arrangement, shown: same ? asked.shown : shown };
}

function pairedWith(asked: ViewState, shown: readonly number[], count: number): number {
  if (asked.against < count) return asked.against;
  return shown.find((model) => model !== shown[0]) ?? Math.max(0, count - 1);
}

// While a performance plays it holds the sliders, at t = 1.
function driven(state: ViewState, models: readonly Model[], before: ViewState | null): ViewState {
  const clip = clipNamed(models, state);
  if (!clip) return state.clip === null ? state : { ...state, clip: null };
  const [first, last] = span(clip);
  const clipTime = Math.min(last, Math.max(first, state.clipTime));
  const unmoved =
    before?.clip === clip.name &&
    before.takes === state.takes &&
    before.clipTime === clipTime &&
    before.weights === state.weights;
  if (unmoved && state.t === 1) return { ...state, clipTime };
  return { ...state, clipTime, t: 1, weights: nonZero(clipWeights(clip, clipTime)) };
}

function nonZero(weights: Record<string, number>): Record<string, number> {
  return Object.fromEntries(Object.entries(weights).filter(([, weight]) => weight !== 0));
}
