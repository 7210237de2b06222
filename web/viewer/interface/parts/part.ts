// What every piece of the interface is: an element, and a function of the state.
import type { Scene } from '../../types/model';
import type { Stage } from '../../types/stage';
import type { ViewState } from '../../types/state';
import type { Store } from '../state/store';

export interface Part {
  readonly element: HTMLElement;
  /** Agrees with the state; called at most once a frame. */
  show(state: ViewState): void;
  /** Another scene is there. */
  load?(scene: Scene | null): void;
}

export interface Context {
  readonly store: Store;
  readonly stage: Stage;
  scene(): Scene | null;
  /** Tells people of a problem, until they have read it. */
  tell(message: string): void;
  /** Says for a moment that something is done. */
  say(words: string): void;
}
