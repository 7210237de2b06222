// The one place where the state of the view lives: everything else is a function of it.
import type { ViewState } from '../../types/state';
import { checked } from './checked';

export type Listener = (state: ViewState, previous: ViewState) => void;

export interface Store {
  get(): ViewState;
  /** Changes some fields. Numbers are clamped; what cannot be understood throws a RangeError. */
  update(patch: Partial<ViewState>): void;
  /** Calls back after every change; returns how to stop that. */
  subscribe(listener: Listener): () => void;
}

/**
 * @param settle makes a state agree with what there is to show: see `settling`.
 */
export function createStore(
  initial: ViewState,
  settle: (state: ViewState) => ViewState = (state) => state,
): Store {
  let state = settle(initial);
  const listeners = new Set<Listener>();
  return {
    get: () => state,
    update(patch) {
      const previous = state;
      const next = settle({ ...previous, ...checked(patch) });
      const keys = Object.keys(next) as (keyof ViewState)[];
      if (keys.every((key) => Object.is(next[key], previous[key]))) return;
      state = next;
      for (const listener of [...listeners]) listener(next, previous);
    },
    subscribe(listener) {
      listeners.add(listener);
      return () => listeners.delete(listener);
    },
  };
}
