// Correctives: how much each adds to what sliders do together, and a switch for each.
import { numberOf } from '../../../shared/named';
import { element, freshId, setAttribute, setText } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import { correctivesOf, pathWeights } from '../../rig/pose';
import type { Model } from '../../types/model';
import type { ViewState } from '../../types/state';
import type { Store } from '../state/store';
import type { createSift } from './slider_sift';

type Path = Model['bender']['morphs'][number];

interface Row {
  readonly name: string;
  readonly element: HTMLElement;
  show(weight: number, off: boolean): void;
}

/** @param folded hears that the group was folded or unfolded. */
export function createCorrectives(store: Store, folded: () => void) {
  let model: Model | null = null;
  let rows: readonly Row[] = [];
  let open = false;
  const count = element('span', { class: 'count' });
  const body = element('div', { class: 'rows' });
  const fold = () => {
    open = !open;
    folded();
  };
  const opener = element(
    'button',
    { type: 'button', onclick: fold },
    icon('chevron'),
    'Correctives',
    count,
  );
  const whole = element('section', { class: 'group' }, element('h2', {}, opener), body);

  const turn = (name: string) => {
    const { correctivesOff } = store.get();
    const others = correctivesOff.filter((other) => other !== name);
    const off = others.length < correctivesOff.length ? others : [...others, name];
    store.update({ correctivesOff: off });
  };
  /** Those that do something first; nothing moves under a hand. */
  const sort = (weights: ViewState['weights']) => {
    if (body.matches(':hover, :focus-within')) return;
    const idle = ({ name }: Row) => Number(numberOf(weights, name) === 0);
    const sorted = rows.toSorted((one, other) => idle(one) - idle(other));
    if (sorted.some((row, i) => row.element !== body.children[i]))
      body.replaceChildren(...sorted.map((row) => row.element));
  };

  return {
    element: whole,
    /** Lists those of another model. */
    list(next: Model | null) {
      model = next;
      const paths = next ? correctivesOf(next) : [];
      rows = paths.map((path) => rowOf(path, next!.sliders, () => turn(path.name)));
      body.replaceChildren(...rows.map((row) => row.element));
    },
    show(state: ViewState, sift: ReturnType<typeof createSift>) {
      const weights = model && rows.length > 0 ? pathWeights(model, state) : {};
      const fits = sift.fits({ weights, favourites: [] });
      const off = new Set(state.correctivesOff);
      let [active, without] = [0, 0];
      for (const row of rows) {
        const weight = numberOf(weights, row.name);
        row.show(weight, off.has(row.name));
        row.element.hidden = !fits(row) && !row.element.contains(document.activeElement);
        if (weight !== 0) active += 1;
        if (off.has(row.name)) without += 1;
      }
      const words = [active && `${active} of ${rows.length}`, without && `${without} off`];
      setText(count, words.filter(Boolean).join(', '));
      sort(weights);
      const closed = !open && !sift.searching();
      setAttribute(opener, 'aria-expanded', String(!closed));
      body.hidden = closed;
      whole.hidden = rows.every((row) => row.element.hidden);
    },
  };
}

function rowOf({ name, target, drivers, law }: Path, sliders: readonly string[], turn: () => void): Row {
  const told = freshId('corrective');
  const box = element('input', { type: 'checkbox', role: 'switch', 'aria-describedby': told });
  box.addEventListener('change', turn);
  const number = element('span', { class: 'weight', id: told });
  const by = `${law} of ${drivers.map((driver) => sliders[driver]).join(', ')}`;
  const title = `${name}: ${target === null ? 'pair bend, ' : ''}${by}`;
  const label = element('label', { class: 'check', title }, box, element('span', {}, name));
  const whole = element('div', { class: 'corrective', 'data-corrective': name }, label, number);
  return {
    name,
    element: whole,
    show(weight, off) {
      box.checked = !off;
      setText(number, weight.toFixed(2));
      setAttribute(whole, 'data-active', weight !== 0 && !off);
    },
  };
}
