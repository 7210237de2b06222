// The timeline of a take, which unfolds above the bar: its range, its sound, its curves, its files.
import { element, setText } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import { grouped } from '../../files/container';
import { clipNamed, frameRate, missed, played } from '../../rig/clips';
import type { Takes } from '../../takes/opening';
import type { Recorder } from '../../takes/video/recording';
import { matchWords } from '../../takes/reading';
import { offsetOf, type Speaker } from '../../takes/sound';
import type { Clip } from '../../types/model';
import type { ViewState } from '../../types/state';
import type { Context, Part } from '../parts/part';
import { createEdits } from './edits';
import { numberField } from './fields';
import { createFiles } from './files';
import { createStrip } from './strip';

export interface Timeline extends Part {
  /** The button that unfolds it. */
  readonly opener: HTMLButtonElement;
  toggle(): void;
}

/** Puts the in or the out point where the clock stands; the other gives way. */
export function mark({ store, scene }: Context, end: 'in' | 'out'): void {
  const state = store.get();
  const clip = clipNamed(scene()?.models ?? [], state);
  if (!clip) return;
  const [first, last] = played(clip, state.range);
  const now = state.clipTime;
  const range = end === 'in' ? [now, Math.max(now, last)] : [Math.min(now, first), now];
  store.update({ range: range as [number, number] });
}

/** @param unfolded hears that it takes room from the picture now */
export function createTimeline(
  context: Context,
  speaker: Speaker,
  takes: Takes,
  recorder: Recorder,
  unfolded: () => void,
): Timeline {
  const { store, scene } = context;
  const clip = (state: ViewState) => clipNamed(scene()?.models ?? [], state);
  const near = element('input', {
    ...{ type: 'range', min: 0, max: 1, step: 0.01, value: 0 },
    ...{ 'aria-label': 'Zoom of the timeline', title: 'Zoom (wheel)' },
  });
  const strip = createStrip(context, speaker, (share) => {
    near.value = String(share);
    edits.show(store.get());
  });
  near.addEventListener('input', () => strip.near(near.valueAsNumber));
  const edits = createEdits(context, strip);
  const files = createFiles(context, takes, recorder);
  const button = (words: string, title: string, run: () => void) => {
    const made = element('button', { type: 'button', title }, words);
    made.addEventListener('click', run);
    return made;
  };
  const about = element('span', { class: 'value' });
  const sound = element('span', { class: 'value' });
  const offset = numberField('Sound +', {
    ...{ step: 0.01, unit: 's' },
    title: 'Seconds that the sound begins after the take',
  });
  offset.input.addEventListener('change', () => {
    const { clip, soundOffsets } = store.get();
    store.update({ soundOffsets: { ...soundOffsets, [clip ?? '']: offset.value() } });
  });
  const whole = button('Whole', 'The whole take', () => store.update({ range: null }));
  const line = element(
    'div',
    { class: 'range-line' },
    button('In', 'Begin here ({)', () => mark(context, 'in')),
    button('Out', 'End here (})', () => mark(context, 'out')),
    ...[whole, about, sound, offset.element],
    element('label', { class: 'near' }, icon('search'), near),
  );
  const opener = element(
    'button',
    {
      ...{ type: 'button', class: 'unfold', 'aria-keyshortcuts': 'T' },
      ...{ 'aria-expanded': 'false', title: 'Timeline (T)' },
    },
    'Timeline',
  );
  const all = element(
    'section',
    { class: 'timeline', 'aria-label': 'Timeline', hidden: true },
    ...[line, strip.element, element('div', { class: 'take-lines' }, edits.element, files.element)],
  );
  let open = false;
  let described: Clip | null = null; // the take whose frames and match can be read
  let frames = '';
  let opened: readonly unknown[] = [];

  const show = (state: ViewState) => {
    const of = clip(state);
    // Whoever opens a take wants to see it.
    if (of?.recorded && !opened.includes(of.recorded)) open = true;
    opened = state.takes.map(({ recorded }) => recorded);
    const hidden = !open || !of;
    if (all.hidden && !hidden) unfolded();
    all.hidden = hidden;
    opener.hidden = !of;
    opener.setAttribute('aria-expanded', String(open));
    if (!of || all.hidden) return;
    const [first, last] = played(of, state.range);
    whole.disabled = state.range === null;
    const [start, end] = [first, last].map((seconds) => seconds.toFixed(2));
    if (of !== described) {
      described = of;
      frames = framesWords(of);
      about.title = matchWords(of, scene()?.models[state.shown[0] ?? 0]?.sliders ?? []);
    }
    setText(about, state.range ? `${start}–${end} s` : frames);
    const heard = speaker.of(of.name);
    setText(sound, heard ? `♪ ${heard.name}` : '');
    offset.element.hidden = sound.hidden = !heard;
    offset.show(String(Number(offsetOf(state).toFixed(3))));
    strip.show(state);
    edits.show(state);
    files.show(state);
  };
  const toggle = () => {
    open = all.clientHeight === 0; // a sheet may hide it
    show(store.get());
    if (open) unfolded();
  };
  opener.addEventListener('click', toggle);
  speaker.subscribe(() => show(store.get()));
  return { element: all, opener, show, toggle };
}

function framesWords(clip: Clip): string {
  const missing = missed(clip);
  const words = `${grouped(clip.times.length)} frames, ${Number(frameRate(clip).toFixed(2))} fps`;
  return missing > 0 ? `${words}, ${grouped(missing)} missing` : words;
}
