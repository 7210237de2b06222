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

/**
 * While it is recorded the dialogue stays, so that nothing behind it can change the picture.
 *
 * @param save hears of a video that is whole, and whose it is.
 */
export function createVideo(
  { store, tell }: Context,
  recorder: Recorder,
  save: (take: string, video: Blob) => void,
): HTMLElement {
  const size = choice('Size', Object.keys(SIZES));
  const wall = choice('Background', Object.keys(WALLS));
  const begin = element('button', { type: 'button', class: 'primary' });
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
  const show = (recording: boolean, words: string) => {
    setText(begin, words);
    size.input.disabled = wall.input.disabled = recording;
  };
  show(false, 'Record');
  close.addEventListener('click', () => dialog.close());
  dialog.addEventListener('close', recorder.stop);
  button.addEventListener('click', () => {
    document.querySelector('main')!.append(dialog); // nothing around it hides it there
    dialog.showModal();
  });
  begin.addEventListener('click', ({ detail }) => {
    // The second click of two is none that stops what the first began.
    if (recorder.recording()) return detail > 1 ? undefined : recorder.stop();
    const take = store.get().clip ?? 'take';
    const options = {
      size: SIZES[size.input.value] ?? null,
      dark: WALLS[wall.input.value] ?? null,
    };
    show(true, 'Stop');
    recorder
      .record(options, (share) => show(true, `Stop (${Math.floor(100 * share)} %)`))
      .then((video) => video && save(take, video))
      .catch((problem: unknown) => tell(wordsOf(problem)))
      .finally(() => {
        dialog.close();
        show(false, 'Record');
      });
  });
  return button;
}

function choice(words: string, names: readonly string[]) {
  const input = element('select', {}, ...names.map((name) => element('option', {}, name)));
  return { input, element: element('label', { class: 'row' }, words, input) };
}
