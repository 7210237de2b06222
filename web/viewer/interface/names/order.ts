// Sorts sliders into the groups of the file, or else by the part of the face they move.
import type { Model } from '../../types/model';
import { placeOf, REGIONS, regionOf } from './arkit';

export interface SliderGroup {
  readonly name: string;
  readonly sliders: readonly string[];
}

export function sliderGroups(model: Model): SliderGroup[] {
  const left = new Set(model.sliders);
  const groups: { name: string; sliders: string[] }[] = [];
  for (const { name, members } of model.groups) {
    const sliders = members.filter((member) => left.delete(member));
    if (sliders.length > 0) groups.push({ name, sliders });
  }
  for (const region of REGIONS) {
    const sliders = [...left].filter((slider) => regionOf(slider) === region);
    if (sliders.length > 0) groups.push({ name: region, sliders });
  }
  // One region is no grouping.
  if (groups.length === 1 && model.groups.length === 0) groups[0]!.name = 'All';
  return groups.map(({ name, sliders }) => ({ name, sliders: inOrder(sliders) }));
}

// ARKit's names in ARKit's order; others after them, as in the file.
function inOrder(sliders: readonly string[]): string[] {
  const place = new Map(sliders.map((slider) => [slider, placeOf(slider) ?? Infinity]));
  const of = (slider: string) => place.get(slider) ?? Infinity;
  return [...sliders].sort((a, b) => (of(a) === of(b) ? 0 : of(a) - of(b)));
}
