// Vertices people pick to see their orbits.
import type { ViewState } from '../../types/state';

const MANY = 200; // more of them hide the face

/** Adds a vertex to those picked, or takes it away. */
export function togglePicked(state: ViewState, vertex: number): Partial<ViewState> {
  const picked = state.picked.includes(vertex)
    ? state.picked.filter((other) => other !== vertex)
    : [...state.picked, vertex].slice(-MANY);
  return { picked, orbits: true };
}

/** Adds a vertex to those picked; null where it is there already. */
export function picking(state: ViewState, vertex: number): Partial<ViewState> | null {
  return state.picked.includes(vertex) ? null : togglePicked(state, vertex);
}
