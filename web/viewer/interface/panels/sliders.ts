// The sliders of the face: found by name, in groups, alone or in symmetric pairs.
import type { Model } from '../../types/model';
import type { ViewState } from '../../types/state';
import { sliderGroups } from '../names/order';
import { twins } from '../names/pairs';
import { toggle } from '../parts/controls';
import { element, setText } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import type { Context, Part } from '../parts/part';
import { type SliderRow, sliderRow } from './slider_row';

const REACH = [0, 1] as const;
const REACH_BEYOND = [-0.5, 1.5] as const;

interface Section {
  readonly element: HTMLElement;
  readonly count: HTMLElement;
  readonly rows: readonly SliderRow[];
}

export interface Sliders extends Part {
  search(): void;
  /** Empties the search; false where it was empty. */
  clearSearch(): boolean;
}

export function createSliders({ store, scene }: Context): Sliders {
  let model: Model | null = null;
  let sections: Section[] = [];
  let pairs: ReadonlyMap<string, string> = new Map();
  let beyond = false;

  const field = element('input', {
    type: 'search',
    placeholder: 'Search sliders',
    'aria-label': 'Search sliders',
    'aria-keyshortcuts': '/',
    autocomplete: 'off',
    spellcheck: 'false',
  });
  const onlyActive = element('input', { type: 'checkbox' });
  const beyondBox = element('input', { type: 'checkbox' });
  const mirror = toggle(store, 'mirror', 'Mirror', 'M');
  const count = element('span', { class: 'count' });
  const reset = element('button', { type: 'button', 'aria-keyshortcuts': '0' }, 'Reset all');
  const list = element('div', { class: 'slider-list' });
  const none = element('p', { class: 'hint', hidden: true });

  const change = (name: string, weight: number) => {
    const state = store.get();
    const twin = state.mirror ? pairs.get(name) : undefined;
    store.update({
      weights: { ...state.weights, [name]: weight, ...(twin ? { [twin]: weight } : {}) },
      // Whoever moves a slider takes over from the performance, and wants to see it move.
      ...(state.clip === null ? {} : { clip: null, playing: false }),
      ...(state.t === 0 && !state.playing ? { t: 1 } : {}),
    });
  };

  const rebuild = (next: Model | null) => {
    model = next;
    const groups = next ? sliderGroups(next) : [];
    pairs = twins(next?.sliders ?? []);
    sections = groups.map(({ name, sliders }) => {
      const rows = sliders.map((slider) => sliderRow(slider, (to) => change(slider, to)));
      const active = element('span', { class: 'count' });
      const body = element('div', { class: 'rows' }, ...rows.map((row) => row.element));
      const opener = element(
        'button',
        { type: 'button', 'aria-expanded': 'true' },
        icon('chevron'),
        name,
        active,
      );
      opener.addEventListener('click', () => {
        body.hidden = !body.hidden;
        opener.setAttribute('aria-expanded', String(!body.hidden));
      });
      const whole = element('section', { class: 'group' }, element('h2', {}, opener), body);
      return { element: whole, count: active, rows };
    });
    list.replaceChildren(none, ...sections.map((section) => section.element));
    reachOut();
  };

  const reachOut = () => {
    beyondBox.checked = beyond;
    const [least, most] = beyond ? REACH_BEYOND : REACH;
    for (const { rows } of sections) for (const row of rows) row.reach(least, most);
  };

  const sift = (state: ViewState) => {
    const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
    let left = 0;
    for (const section of sections) {
      let visible = 0;
      for (const row of section.rows) {
        const name = row.name.toLowerCase();
        const fits = words.every((word) => name.includes(word));
        const hidden = !fits || (onlyActive.checked && !state.weights[row.name]);
        // A row that is being moved stays, though it passes through zero.
        row.element.hidden = hidden && !row.element.contains(document.activeElement);
        if (!row.element.hidden) visible += 1;
      }
      section.element.hidden = visible === 0;
      left += visible;
    }
    none.hidden = left > 0;
    setText(
      none,
      (model?.sliders.length ?? 0) === 0
        ? 'This model has no morph targets, so there is nothing to move.'
        : words.length > 0
          ? `No slider is called “${field.value}”${onlyActive.checked ? ' and active' : ''}.`
          : 'No slider is active.',
    );
  };

  const show = (state: ViewState) => {
    const next = scene()?.models[state.shown[0] ?? 0] ?? null;
    if (next !== model) rebuild(next);
    const weights = Object.values(state.weights);
    if (!beyond && state.clip === null && weights.some((weight) => weight < 0 || weight > 1)) {
      beyond = true;
      reachOut();
    }
    let all = 0;
    for (const section of sections) {
      let active = 0;
      for (const row of section.rows) {
        const weight = state.weights[row.name] ?? 0;
        row.show(weight, state.mirror && pairs.has(row.name));
        if (weight !== 0) active += 1;
      }
      setText(section.count, active > 0 ? `${active} of ${section.rows.length}` : '');
      all += active;
    }
    setText(count, `${all} of ${model?.sliders.length ?? 0} active`);
    reset.disabled = all === 0;
    mirror.show(state);
    mirror.refuse(pairs.size === 0 ? 'No left and right halves by name.' : null);
    sift(state);
  };

  field.addEventListener('input', () => sift(store.get()));
  onlyActive.addEventListener('change', () => sift(store.get()));
  beyondBox.addEventListener('change', () => {
    beyond = beyondBox.checked;
    if (!beyond) store.update({ weights: within(store.get().weights), clip: null });
    reachOut();
  });
  reset.addEventListener('click', () => store.update({ weights: {}, clip: null, playing: false }));

  const searchBox = element('div', { class: 'search' }, icon('search'), field);
  const options = element(
    'div',
    { class: 'slider-options' },
    mirror.element,
    element(
      'label',
      { class: 'check', title: 'Show only sliders that are not 0' },
      onlyActive,
      'Active only',
    ),
    element('label', { class: 'check', title: 'Weights from −0.5 to 1.5' }, beyondBox, 'Beyond 1'),
  );
  const whole = element(
    'div',
    { class: 'sliders' },
    element('div', { class: 'slider-head' }, searchBox, options),
    list,
    element('div', { class: 'slider-foot' }, count, reset),
  );
  return {
    element: whole,
    show,
    search() {
      field.focus();
      field.select();
    },
    clearSearch() {
      if (field.value === '') return false;
      field.value = '';
      sift(store.get());
      return true;
    },
  };
}

function within(weights: Readonly<Record<string, number>>): Record<string, number> {
  const clamped = Object.entries(weights).map(
    ([name, weight]) => [name, Math.min(1, Math.max(0, weight))] as const,
  );
  return Object.fromEntries(clamped);
}
