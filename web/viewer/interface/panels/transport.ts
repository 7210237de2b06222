// The bar under the picture: what plays, where it is, and how it goes on.
import type { TimingName, ViewState } from '../../types/state';
import { fill } from '../parts/controls';
import { element, setAttribute, setText } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import type { Context, Part } from '../parts/part';
import type { Player } from '../state/player';
import { clipNamed, frameAt, performances, span } from '../../rig/clips';
import type { Timeline } from '../timeline/timeline';
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

export function createTransport(
  { store, scene }: Context,
  player: Player,
  timeline: Timeline,
): Part {
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

  const speed = element('input', {
    ...{ type: 'number', min: 0.1, max: 2, step: 0.1 },
    ...{ 'aria-label': 'Speed', title: 'Speed, 0.1 to 2' },
  });
  const ofSpeed = element(
    'span',
    { class: 'seconds' },
    speed,
    element('span', { 'aria-hidden': 'true' }, '×'),
  );
  const models = () => scene()?.models ?? [];

  play.addEventListener('click', () => player.toggle());
  source.addEventListener('change', () => {
    const clip = clipNamed(models(), { ...store.get(), clip: source.value || null });
    const clipTime = clip ? span(clip)[0] : 0;
    // Without one, the pose of that moment stays.
    store.update({ clip: clip?.name ?? null, clipTime, range: null, playing: false });
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

  speed.addEventListener('change', () => {
    if (Number.isFinite(speed.valueAsNumber)) store.update({ speed: speed.valueAsNumber });
    speed.value = String(store.get().speed);
  });

  let offered: string | null = null;
  const offer = (state: ViewState) => {
    const names = performances(models(), state.takes).map(({ name }) => name);
    if (names.join('\n') === offered) return;
    offered = names.join('\n');
    source.replaceChildren(
      element('option', { value: POSE }, 'Pose (t)'),
      ...names.map((name) => element('option', { value: name }, name)),
    );
    source.hidden = names.length === 0;
  };

  const show = (state: ViewState) => {
    const clip = clipNamed(models(), state);
    offer(state);
    const words = state.playing ? 'Pause' : 'Play';
    if (play.getAttribute('aria-label') !== words) {
      play.setAttribute('aria-label', words);
      play.title = `${words} (space)`;
      play.replaceChildren(state.playing ? pauseIcon : playIcon);
    }
    source.value = state.clip ?? POSE;
    const [first, last] = clip ? span(clip) : [0, 1];
    const frame = clip ? frameAt(clip, state.clipTime) : 0;
    const now = clip ? state.clipTime : state.t;
    range(scrub, first, last, clip ? 0.01 : 0.005);
    if (scrub.valueAsNumber !== now) scrub.valueAsNumber = now;
    fill(scrub, first, now);
    const moment = `${now.toFixed(2)} / ${last.toFixed(2)} s`;
    const text = clip ? `${moment} · ${frame}` : `t ${now.toFixed(3)}`;
    setText(place, text);
    scrub.setAttribute('aria-label', clip ? `Seconds of ${clip.name}` : 'Master time t');
    scrub.setAttribute('aria-valuetext', clip ? `${now.toFixed(2)} seconds, frame ${frame}` : text);
    place.title = clip ? 'Seconds, and number of the frame' : '';
    repeat.value = state.repeat;
    timing.value = state.timing;
    picture.show(state.timing, player.phase());
    if (document.activeElement !== seconds) seconds.value = String(state.seconds);
    if (document.activeElement !== speed) speed.value = String(state.speed);
    ofTiming.hidden = clip !== null;
    ofSpeed.hidden = clip === null;
    timeline.show(state);
  };

  return {
    element: element(
      'div',
      { class: 'transport', role: 'group', 'aria-label': 'Playback' },
      timeline.element,
      element('div', { class: 'of-time' }, play, source, scrub, place),
      element('div', { class: 'of-play' }, repeat, ofTiming, ofSpeed, timeline.opener),
    ),
    show,
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
