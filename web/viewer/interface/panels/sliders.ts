// The sliders of the face: found by name, in groups, alone or in symmetric pairs.
import { numberOf } from '../../../shared/named';
import type { Model } from '../../types/model';
import type { ViewState } from '../../types/state';
import { sliderGroups } from '../names/order';
import { opposites, twins } from '../names/pairs';
import { toggle } from '../parts/controls';
import { element, setAttribute, setText } from '../../../shared/element';
import { type Icon, icon } from '../../../shared/icons';
import type { Context, Part } from '../parts/part';
import { drawn, type Limits, lots, mirrored } from '../poses/mixing';
import { atRest, posed } from '../state/posing';
import { createCorrectives } from './correctives';
import { type SliderGroup, sliderGroup } from './slider_group';
import { createSift } from './slider_sift';
import { sliderRow } from './slider_row';

const REACH: Limits = [0, 1];
const REACH_BEYOND: Limits = [-0.5, 1.5];

export interface Sliders extends Part {
  search(): void;
  /** Highlights what a gesture has moved; brings it into view when it is over. */
  moved(names: readonly string[], over: boolean): void;
  /** Empties the search; false where it was empty. */
  clearSearch(): boolean;
  /** Left and right exchanged. */
  swap(): void;
  /** Another expression of the sliders that are shown. */
  draw(): void;
  /** Makes the slider in focus a favourite, or one no more. */
  star(): void;
}

export function createSliders({ store, scene }: Context): Sliders {
  let model: Model | null = null;
  let groups: SliderGroup[] = [];
  let pairs: ReadonlyMap<string, string> = new Map();
  let across: ReadonlyMap<string, string> = new Map();
  let beyond = false;
  const lot = lots(1); // the same faces after each loading of the page

  const sift = createSift(() => show(store.get()));
  const beyondBox = element('input', { type: 'checkbox' });
  const mirror = toggle(store, 'mirror', 'Mirror', 'M');
  const count = element('span', { class: 'count' });
  const list = element('div', { class: 'slider-list' });
  const correctives = createCorrectives(store, () => show(store.get()));

  const pose = (weights: ViewState['weights']) => store.update(posed(store.get(), weights));
  const change = (name: string, weight: number) => {
    const { mirror, weights } = store.get();
    const twin = mirror ? pairs.get(name) : undefined;
    pose({ ...weights, [name]: weight, ...(twin ? { [twin]: weight } : {}) });
  };
  const zero = (sliders: readonly string[]) => {
    const none = Object.fromEntries(sliders.map((slider) => [slider, 0]));
    pose({ ...store.get().weights, ...none });
  };
  const flip = (field: 'favourites' | 'folded', name: string) => {
    const names = store.get()[field];
    const others = names.filter((other) => other !== name);
    store.update({ [field]: names.length > others.length ? others : [...names, name] });
  };
  const draw = () => {
    const { weights, mirror, folded } = store.get();
    const shown = groups.filter((group) => sift.searching() || !folded.includes(group.name));
    const rows = shown.flatMap((group) => group.rows.filter((row) => !row.element.hidden));
    const together = mirror ? pairs : new Map<string, string>();
    const names = rows.map((row) => row.name);
    pose(drawn(weights, names, together, beyond ? REACH_BEYOND : REACH, lot));
  };
  const swap = () => pose(mirrored(store.get().weights, across));
  const reset = element('button', { type: 'button', 'aria-keyshortcuts': '0' }, 'Reset all');
  const swapButton = tool('swap', 'Swap left and right (X)', 'X', swap);
  const drawButton = tool('dice', 'Random: six of the sliders shown (R)', 'R', draw);

  const rebuild = (next: Model | null) => {
    model = next;
    pairs = twins(next?.sliders ?? []);
    across = opposites(next?.sliders ?? []);
    groups = (next ? sliderGroups(next) : []).map(({ name, sliders }) => {
      const rows = sliders.map((slider) =>
        sliderRow(
          slider,
          (to) => change(slider, to),
          () => flip('favourites', slider),
        ),
      );
      return sliderGroup(
        name,
        rows,
        () => flip('folded', name),
        () => zero(sliders),
      );
    });
    correctives.list(next);
    list.replaceChildren(
      sift.none,
      ...groups.map((group) => group.element),
      correctives.element,
    );
    reachOut();
  };

  const reachOut = () => {
    beyondBox.checked = beyond;
    const [least, most] = beyond ? REACH_BEYOND : REACH;
    for (const { rows } of groups) for (const row of rows) row.reach(least, most);
  };

  const show = (state: ViewState) => {
    const next = scene()?.models[state.shown[0] ?? 0] ?? null;
    if (next !== model) rebuild(next);
    const weights = Object.values(state.weights);
    if (!beyond && state.clip === null && weights.some((weight) => weight < 0 || weight > 1)) {
      beyond = true;
      reachOut();
    }
    const favourites = new Set(state.favourites);
    const fits = sift.fits(state);
    let [all, shown] = [0, 0];
    for (const group of groups) {
      for (const row of group.rows) {
        const weight = numberOf(state.weights, row.name);
        row.show(weight, state.mirror && pairs.has(row.name), favourites.has(row.name));
        if (weight !== 0) all += 1;
      }
      shown += group.show(state, fits, state.folded.includes(group.name) && !sift.searching());
    }
    correctives.show(state, sift);
    sift.tell(model?.sliders.length ?? 0, shown);
    setText(count, `${all} of ${model?.sliders.length ?? 0} active`);
    reset.disabled = all === 0 && state.correctivesOff.length === 0;
    swapButton.disabled = all === 0 || across.size === 0;
    drawButton.disabled = shown === 0;
    mirror.show(state);
    mirror.refuse(pairs.size === 0 ? 'No left and right halves by name.' : null);
  };

  beyondBox.addEventListener('change', () => {
    beyond = beyondBox.checked;
    if (!beyond) pose(within(store.get().weights));
    reachOut();
  });
  reset.addEventListener('click', () => store.update(atRest(store.get())));

  const options = element(
    'div',
    { class: 'slider-options' },
    mirror.element,
    sift.onlyActive,
    element('label', { class: 'check', title: 'Weights from −0.5 to 1.5' }, beyondBox, 'Beyond 1'),
  );
  return {
    element: element(
      'div',
      { class: 'sliders' },
      element(
        'div',
        { class: 'scroll' },
        element('div', { class: 'slider-head' }, sift.element, options),
        list,
      ),
      element('div', { class: 'slider-foot' }, count, swapButton, drawButton, reset),
    ),
    show,
    search: sift.search,
    clearSearch: sift.clear,
    swap,
    draw,
    star() {
      const row = document.activeElement?.closest<HTMLElement>('[data-slider]');
      if (row?.dataset['slider']) flip('favourites', row.dataset['slider']);
    },
    moved(names, over) {
      const rows = groups.flatMap((group) => group.rows);
      const own = rows.filter((row) => names.includes(row.name));
      for (const row of rows) setAttribute(row.element, 'data-moved', own.includes(row));
      const seen = own.find((row) => row.element.offsetParent !== null);
      if (over) seen?.element.scrollIntoView({ block: 'nearest' });
    },
  };
}

function within(weights: Readonly<Record<string, number>>): Record<string, number> {
  const clamped = Object.entries(weights).map(
    ([name, weight]) => [name, Math.min(1, Math.max(0, weight))] as const,
  );
  return Object.fromEntries(clamped);
}

function tool(drawing: Icon, words: string, key: string, run: () => void): HTMLButtonElement {
  const made = element('button', { type: 'button', title: words, onclick: run }, icon(drawing));
  setAttribute(made, 'aria-label', words.replace(/ \(.\)$/, ''));
  setAttribute(made, 'aria-keyshortcuts', key);
  return made;
}
