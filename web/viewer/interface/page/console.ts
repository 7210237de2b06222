// `window.elastomorph`: the viewer for scripts, tests and the curious at the console.
import { Search, type Solved } from '../../grab/solving';
import type { Readout, Spot, View } from '../../types/stage';
import type { ViewState } from '../../types/state';
import type { App } from './app';

export interface Elastomorph {
  /** Kept when the page has drawn its scene for the first time, or found that it has none. */
  readonly ready: Promise<void>;
  /** Everything the picture depends on. */
  state(): ViewState;
  /**
   * Changes parts of it: `elastomorph.update({ weights: { jawOpen: 0.7 }, t: 0.5 })`. Numbers are
   * clamped; a field or word that does not exist throws a RangeError which says what does.
   */
  update(patch: Partial<ViewState>): void;
  /** Positions of a model's vertices as drawn now: x, y, z of the first, of the second, … */
  positions(model?: number): Float32Array;
  /** Frame time, active targets, memory, and the worst distance while the heat map is on. */
  readout(): Readout;
  models(): { name: string; role: string; vertices: number }[];
  /** Where a point of a model is on the picture, in CSS pixels; null where it is not shown. */
  spot(position: readonly number[], model?: number): Spot | null;
  /**
   * Weights that bring vertices to positions, from those of the state, as `Rig.solve` of Python:
   * `const { weights } = elastomorph.solve({ 912: [0, -6, 4] })`. `prior` is the cost of a slider.
   */
  solve(goals: Readonly<Record<number, readonly number[]>>, prior?: number): Solved;
  /** Turns to 'front', 'three-quarter', 'side' or 'below'. */
  look(view: View): void;
}

declare global {
  interface Window {
    elastomorph: Elastomorph;
  }
}

export function onConsole(app: App, ready: Promise<void>): Elastomorph {
  const drawn = () => {
    app.stage.show(app.store.get());
    app.stage.flush();
  };
  return {
    ready,
    state: app.store.get,
    update: app.store.update,
    positions(model = app.store.get().shown[0] ?? 0) {
      const count = app.scene()?.models.length ?? 0;
      if (!Number.isInteger(model) || model < 0 || model >= count) {
        throw new RangeError(`there is no model ${model}; the page shows ${count}`);
      }
      drawn();
      return app.stage.positions(model);
    },
    readout() {
      if (app.scene()) drawn();
      return app.stage.readout();
    },
    models: () =>
      (app.scene()?.models ?? []).map(({ name, role, neutral }) => ({
        name,
        role,
        vertices: neutral.length / 3,
      })),
    spot(position, model = app.store.get().shown[0] ?? 0) {
      drawn();
      return app.stage.spot(model, position);
    },
    solve(goals, prior = 1e-8) {
      const { weights, t, shown, correctivesOff: off } = app.store.get();
      const model = app.scene()?.models[shown[0] ?? 0];
      if (!model) throw new RangeError('there is no face');
      const search = new Search(model, Object.keys(goals).map(Number), { t, off });
      return search.solve({ goals: Object.values(goals).flat(), start: weights, prior });
    },
    look: app.look,
  };
}
