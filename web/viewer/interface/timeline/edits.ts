// The line of a timeline with which curves are edited: which, how, and how far.
import { element } from '../../../shared/element';
import { clipNamed, played } from '../../rig/clips';
import * as editing from '../../takes/editing';
import { withTake } from '../../takes/opening';
import type { Clip } from '../../types/model';
import type { ViewState } from '../../types/state';
import type { Context } from '../parts/part';
import { numberField } from './fields';
import { moving, nearestFrame } from './sight';
import type { Strip } from './strip';

type Edit = (amount: number, range: editing.Frames, reach: number) => editing.Change;

interface Offer {
  readonly words: string;
  readonly unit: string;
  readonly amount: number; // to begin with
  readonly bounds?: readonly [number, number];
  readonly edit: Edit;
}

const EDITS: Readonly<Record<string, Offer>> = {
  gaussian: {
    words: 'Smooth',
    unit: 'frames',
    amount: 3,
    bounds: [1, editing.STRONGEST],
    edit: (amount, ...where) => editing.smooth('gaussian', amount, ...where),
  },
  'savitzky-golay': {
    words: 'Smooth, keep peaks',
    unit: 'frames',
    amount: 4,
    bounds: [2, editing.STRONGEST],
    edit: (amount, ...where) => editing.smooth('savitzky-golay', amount, ...where),
  },
  offset: { words: 'Offset', unit: '', amount: 0.1, edit: editing.offset },
  scale: { words: 'Scale', unit: '×', amount: 1.2, edit: editing.scale },
  slide: { words: 'Slide in time', unit: 'frames', amount: 1, edit: editing.slide },
};

export interface EditLine {
  readonly element: HTMLElement;
  show(state: ViewState): void;
}

export function createEdits({ store, scene }: Context, strip: Strip): EditLine {
  const curve = element('select', { 'aria-label': 'Curve', title: 'Curve that is edited' });
  const value = numberField('Value', {
    ...{ step: 0.01, min: -editing.FARTHEST, max: editing.FARTHEST },
    title: 'Value of the curve at the frame shown',
  });
  const reach = numberField('Falloff', {
    ...{ step: 1, min: 0, max: 500, unit: 'frames' },
    title: 'Frames beside a key or a range that go with it',
  });
  const kind = element(
    'select',
    { 'aria-label': 'Edit', title: 'What to do from the in to the out point' },
    ...Object.entries(EDITS).map(([name, { words }]) => element('option', { value: name }, words)),
  );
  const amount = numberField('Amount', { step: 'any', title: 'How far' });
  const apply = element('button', { type: 'button' }, 'Apply');
  reach.input.value = '4';
  strip.reach(4);

  const offer = () => EDITS[kind.value]!;
  const clip = () => clipNamed(scene()?.models ?? [], store.get());
  const replace = (of: Clip) => store.update({ takes: withTake(store.get().takes, of) });
  const renew = () => {
    const [least = '', most = ''] = offer().bounds ?? [];
    [amount.input.min, amount.input.max] = [String(least), String(most)];
    amount.input.value = String(offer().amount);
    amount.unit(offer().unit);
  };
  renew();

  curve.addEventListener('change', () => strip.choose(curve.value));
  kind.addEventListener('change', renew);
  reach.input.addEventListener('input', () => strip.reach(reach.value()));
  value.input.addEventListener('change', () => {
    const of = clip();
    const slider = strip.chosen();
    if (!of || !slider || !Number.isFinite(value.input.valueAsNumber)) return;
    const frame = nearestFrame(of, store.get().clipTime);
    replace(
      editing.edited(
        of,
        [slider],
        editing.moveKey(frame, value.value(), reach.value()),
      ),
    );
  });
  apply.addEventListener('click', () => {
    const of = clip();
    if (!of || !Number.isFinite(amount.input.valueAsNumber)) return;
    const [first, last] = played(of, store.get().range);
    const frames = [nearestFrame(of, first), nearestFrame(of, last)] as const;
    const change = offer().edit(amount.value(), frames, reach.value());
    replace(editing.edited(of, strip.chosen() ? [strip.chosen()] : moving(of), change));
  });

  let listed: readonly string[] = [];
  return {
    element: element(
      'div',
      { class: 'edits', role: 'group', 'aria-label': 'Edit curves' },
      ...[curve, value.element, reach.element, kind, amount.element, apply],
    ),
    show({ clipTime }) {
      const of = clip();
      if (!of) return;
      const names = moving(of);
      const kept = strip.chosen();
      if (kept && !names.includes(kept)) names.push(kept);
      if (names.join() !== listed.join()) {
        listed = names;
        curve.replaceChildren(
          element('option', { value: '' }, `All that move (${names.length})`),
          ...names.map((name) => element('option', { value: name }, name)),
        );
      }
      if (curve.value !== kept) curve.value = kept;
      const track = of.tracks.get(kept);
      value.input.disabled = !track;
      value.show(track ? (track[nearestFrame(of, clipTime)] ?? 0).toFixed(3) : '');
    },
  };
}
