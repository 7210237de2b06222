// What else changes when somebody poses the face.
import type { ViewState } from '../../types/state';

/** The face at rest, with all its correctives. */
export function atRest(state: ViewState): Partial<ViewState> {
  return { ...posed(state, {}), correctivesOff: [] };
}

/** Whoever moves sliders takes over from a performance or a phone, and wants to see them move. */
export function posed(state: ViewState, weights: ViewState['weights']): Partial<ViewState> {
  return {
    weights,
    live: false,
    ...(state.clip === null ? {} : { clip: null, playing: false }),
    ...(state.t === 0 && !state.playing ? { t: 1 } : {}),
  };
}
