// The bar under the picture: what plays, where it is, and how it goes on.
import type { TimingName, ViewState } from '../../types/state';
import { fill } from '../parts/controls';
import { element, setAttribute, setText } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import type { Context, Part } from '../parts/part';
import type { Player } from '../state/player';
import { clipNamed, performances, span } from '../state/settling';
import { timingPicture } from './timing_picture';

const REPEATS: readonly (readonly [ViewState['repeat'], string])[] = [
  ['once', 'Once'],
  ['loop', 'Loop'],
  ['back and forth', 'Back and forth'],
];
const TIMINGS: readonly (readonly [TimingName, string])[] = [
  ['linear', 'Linear'],
  ['smoothstep', 'Smoothstep'],
  ['minimum-jerk', 'Minimum jerk'],
  ['cosine', 'Cosine'],
  ['blink', 'Blink'],
];
const POSE = ''; // the value of the choice in which the sliders, not a performance, make the face

export function createTransport({ store, scene }: Context, player: Player): Part {
  const play = element('button', {
    type: 'button',
    class: 'play',
    'aria-keyshortcuts': 'Space',
  });
  const [playIcon, pauseIcon] = [icon('play'), icon('pause')];
  const source = element('select', { 'aria-label': 'What plays' });
  const scrub = element('input', { type: 'range', class: 'scrub' });
  const place = element('span', { class: 'value' });
  const repeat = select('Repeat', REPEATS, (value) => store.update({ repeat: value }));
  const timing = select('Timing', TIMINGS, (value) => store.update({ timing: value }));
  const picture = timingPicture();
  const seconds = element('input', {
    type: 'number',
    'aria-label': 'Seconds from t = 0 to 1',
    title: 'Seconds from t = 0 to 1',
    min: 0.1,
    max: 60,
    step: 0.1,
  });
  const ofTiming = element(
    'div',
    { class: 'of-timing' },
    picture.element,
    timing,
    element('span', { class: 'seconds' }, seconds, element('span', { 'aria-hidden': 'true' }, 's')),
  );

  play.addEventListener('click', () => player.toggle());
  source.addEventListener('change', () => {
    const clip = clipNamed(scene()?.models ?? [], source.value || null);
    if (clip) store.update({ clip: clip.name, clipTime: span(clip)[0], playing: false });
    else store.update({ clip: null, playing: false }); // the pose of that moment stays
    show(store.get()); // the timeline has other ends now
  });
  scrub.addEventListener('input', () => {
    const place = scrub.valueAsNumber;
    const playing = false; // who takes hold of the timeline wants it to stand still
    store.update(store.get().clip === null ? { t: place, playing } : { clipTime: place, playing });
  });
  seconds.addEventListener('change', () => {
    if (Number.isFinite(seconds.valueAsNumber)) store.update({ seconds: seconds.valueAsNumber });
    seconds.value = String(store.get().seconds);
  });

  const load = () => {
    const takes = performances(scene()?.models ?? []);
    source.replaceChildren(
      element('option', { value: POSE }, 'Pose (t)'),
      ...takes.map(({ name }) => element('option', { value: name }, name)),
    );
    source.hidden = takes.length === 0;
  };

  const show = (state: ViewState) => {
    const clip = clipNamed(scene()?.models ?? [], state.clip);
    const words = state.playing ? 'Pause' : 'Play';
    if (play.getAttribute('aria-label') !== words) {
      play.setAttribute('aria-label', words);
      play.title = `${words} (space)`;
      play.replaceChildren(state.playing ? pauseIcon : playIcon);
    }
    source.value = state.clip ?? POSE;
    const [first, last] = clip ? span(clip) : [0, 1];
    const now = clip ? state.clipTime : state.t;
    range(scrub, first, last, clip ? 0.01 : 0.005);
    if (scrub.valueAsNumber !== now) scrub.valueAsNumber = now;
    fill(scrub, first, now);
    const text = clip ? `${now.toFixed(2)} / ${last.toFixed(2)} s` : `t ${now.toFixed(3)}`;
    setText(place, text);
    scrub.setAttribute('aria-label', clip ? `Seconds of ${clip.name}` : 'Master time t');
    scrub.setAttribute('aria-valuetext', clip ? `${now.toFixed(2)} seconds` : text);
    repeat.value = state.repeat;
    timing.value = state.timing;
    picture.show(state.timing, player.phase());
    if (document.activeElement !== seconds) seconds.value = String(state.seconds);
    ofTiming.hidden = clip !== null;
  };

  return {
    element: element(
      'div',
      { class: 'transport', role: 'group', 'aria-label': 'Playback' },
      element('div', { class: 'of-time' }, play, source, scrub, place),
      element('div', { class: 'of-play' }, repeat, ofTiming),
    ),
    show,
    load,
  };
}

function range(input: HTMLInputElement, min: number, max: number, step: number): void {
  setAttribute(input, 'min', min);
  setAttribute(input, 'max', max);
  setAttribute(input, 'step', step);
}

function select<T extends string>(
  label: string,
  options: readonly (readonly [T, string])[],
  change: (value: T) => void,
): HTMLSelectElement {
  const made = element(
    'select',
    { 'aria-label': label, title: label },
    ...options.map(([value, words]) => element('option', { value }, words)),
  );
  made.addEventListener('change', () => change(made.value as T));
  return made;
}
