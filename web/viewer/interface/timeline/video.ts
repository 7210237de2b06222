// The dialogue in which a video of a take is asked for, and the button that opens it.
import { element, setText } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import { wordsOf } from '../../../shared/start';
import type { Recorder, VideoOptions } from '../../takes/video/recording';
import type { Context } from '../parts/part';

const SIZES: Readonly<Record<string, VideoOptions['size']>> = {
  'As on the page': null,
  '1280 × 720': [1280, 720],
  '1920 × 1080': [1920, 1080],
  '1080 × 1080': [1080, 1080],
  '1080 × 1920': [1080, 1920],
};
const WALLS: Readonly<Record<string, boolean | null>> = {
  'As on the page': null,
  Light: false,
  Dark: true,
};

/** @param save hears of a video that is whole */
export function createVideo(
  { tell }: Context,
  recorder: Recorder,
  save: (video: Blob) => void,
): HTMLElement {
  const size = choice('Size', Object.keys(SIZES));
  const wall = choice('Background', Object.keys(WALLS));
  const begin = element('button', { type: 'button', class: 'primary' }, 'Record');
  const close = element('button', { type: 'button', 'aria-label': 'Close' }, icon('close'));
  const dialog = element(
    'dialog',
    { 'aria-label': 'Video of the take', class: 'video' },
    element('header', {}, element('h2', {}, 'Video of the take'), close),
    ...[size.element, wall.element],
    element(
      'p',
      { class: 'hint' },
      'Every frame from the in to the out point, at the speed set, with its sound (WebM).',
    ),
    begin,
  );
  const button = element(
    'button',
    { type: 'button', title: 'Record a video of the take' },
    'Video…',
  );
  close.addEventListener('click', () => dialog.close());
  button.addEventListener('click', () => {
    if (recorder.recording()) recorder.stop();
    else {
      document.querySelector('main')!.append(dialog); // nothing around it hides it there
      dialog.showModal();
    }
  });
  begin.addEventListener('click', () => {
    dialog.close();
    const options = {
      size: SIZES[size.input.value] ?? null,
      dark: WALLS[wall.input.value] ?? null,
    };
    recorder
      .record(options, (share) => setText(button, `Stop (${Math.floor(100 * share)} %)`))
      .then((video) => video && save(video))
      .catch((problem: unknown) => tell(wordsOf(problem)))
      .finally(() => setText(button, 'Video…'));
  });
  return button;
}

function choice(words: string, names: readonly string[]) {
  const input = element('select', {}, ...names.map((name) => element('option', {}, name)));
  return { input, element: element('label', { class: 'row' }, words, input) };
}
