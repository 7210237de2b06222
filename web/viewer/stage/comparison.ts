// Distances between the models of a picture.
import { distances, roundedUp } from '../rig/surface';
import type { HeatReadout } from '../types/stage';
import type { ViewState } from '../types/state';
import type { Face } from './face';

/** Measures each pair of posed faces once a pose. */
export class Comparison {
  private readonly last = new Map<number, { key: string; found: ReturnType<typeof distances> }>();

  /** The shown model farthest from the one compared with; null where there is no such pair. */
  of(faces: readonly Face[], shown: readonly number[], state: ViewState): HeatReadout | null {
    const against = faces[state.against];
    if (!state.heat || !against) return null;
    let farthest: Omit<HeatReadout, 'top'> | null = null;
    for (const model of shown) {
      const face = faces[model];
      if (!face || face === against) continue;
      const found = this.between(model, face, against);
      if (!farthest || found.largest > farthest.largest) farthest = { model, ...found };
    }
    if (!farthest) return null;
    const { diameter } = against.model;
    const chosen = state.heatTop !== null && state.heatTop > 0;
    const top = chosen ? state.heatTop * diameter : roundedUp(farthest.largest);
    return { ...farthest, top: top || 1e-3 * diameter };
  }

  forget(): void {
    this.last.clear();
  }

  private between(model: number, face: Face, against: Face): ReturnType<typeof distances> {
    const key = `${face.key}|${against.model.name}|${against.key}`;
    const last = this.last.get(model);
    if (last?.key === key) return last.found;
    const found = distances(face.positions(), against.positions());
    this.last.set(model, { key, found });
    return found;
  }
}
