// What models are called on the page, and the colour that is theirs.
import { modelColours } from '../../stage/colours';
import type { Model } from '../../types/model';

export function colourOf(model: number): string {
  return modelColours[model % modelColours.length] ?? 'currentColor';
}

export function titleOf(model: Model): string {
  return model.role === 'truth' && model.name !== 'recorded' ? `${model.name} (truth)` : model.name;
}
