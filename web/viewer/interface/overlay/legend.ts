// What the colours of the heat map mean.
import { heatColours } from '../../stage/colours';
import type { HeatReadout } from '../../types/stage';
import { digits, lengthAndShare } from '../names/lengths';
import { titleOf } from '../names/models';
import { element, setAttribute, setText } from '../../../shared/element';
import type { Context, Part } from '../parts/part';
import { picking } from '../state/picking';

const TICKS = [0, 0.25, 0.5, 0.75, 1];
const NONE = 1e-6; // of D: what rounding leaves

export interface Legend extends Part {
  readout(heat: HeatReadout | null): void;
}

export function createLegend({ store, scene }: Context): Legend {
  const title = element('div', { class: 'legend-title' });
  const bar = element('div', { class: 'legend-bar' });
  bar.style.background = `linear-gradient(to right, ${heatColours(24).join(', ')})`;
  const lengths = ticks();
  const shares = ticks();
  const scale = element(
    'div',
    { class: 'legend-scale' },
    bar,
    ...lengths.both,
    ...shares.both,
  );
  const worst = element('button', { type: 'button', class: 'worst' });
  let worstVertex: number | null = null;
  worst.title = 'Pick the worst vertex, to see its orbit';
  worst.addEventListener('click', () => {
    if (worstVertex !== null) store.update(picking(store.get(), worstVertex) ?? {});
  });
  const whole = element(
    'div',
    { class: 'legend', role: 'group', 'aria-label': 'Scale of the heat map' },
    title,
    scale,
    worst,
  );

  const small = matchMedia('(max-width: 1000px), (max-height: 600px)');
  const settle = () => {
    const { heat, arrangement } = store.get();
    whole.hidden = !heat;
    setAttribute(whole, 'data-strip', small.matches || arrangement === 'side');
  };
  small.addEventListener('change', settle);

  return {
    element: whole,
    show(state) {
      settle();
      const against = scene()?.models[state.against];
      if (!against) return;
      const itself = state.shown.every((model) => model === state.against);
      scale.hidden = worst.hidden = itself;
      const name = titleOf(against);
      const alone = `This is ${name} itself: measure from another`;
      setText(title, itself ? alone : `Distance from ${name}`);
    },
    readout(heat) {
      const found = scene();
      if (!heat || !found) return;
      const diameter = found.models[0]?.diameter ?? 0;
      lengths.show(heat.top, found.unit, found.unit !== '' || diameter <= 0);
      shares.show((100 * heat.top) / diameter, '% of D', diameter > 0);
      worstVertex = heat.worstVertex;
      const most = lengthAndShare(heat.largest, found.unit, diameter);
      const { shown, against, t, clip } = store.get();
      const several = shown.filter((model) => model !== against).length > 1;
      const model = found.models[heat.model];
      const whose = several && model ? `${titleOf(model)}: worst` : 'Worst';
      const words = `${whose} ${most}, vertex ${heat.worstVertex}`;
      const apart = heat.largest > NONE * diameter;
      const meeting = t === 1 && clip === null ? 'No distance at t = 1: paths meet' : 'No distance';
      setText(worst, apart ? words : meeting);
      worst.disabled = !apart;
    },
  };
}

// A row of numbers under the colours, and their unit beside it.
function ticks() {
  const numbers = TICKS.map((tick) => {
    const number = element('span');
    number.style.left = `${100 * tick}%`;
    return number;
  });
  const row = element('div', { class: 'ticks' }, ...numbers);
  const unit = element('div', { class: 'unit' });
  return {
    both: [row, unit],
    show(top: number, words: string, visible: boolean) {
      row.hidden = unit.hidden = !visible;
      setText(unit, words);
      numbers.forEach((number, i) => setText(number, digits((TICKS[i] ?? 0) * top)));
    },
  };
}
