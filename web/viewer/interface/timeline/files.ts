// The line of a timeline with its files: a take or a sound to open, and what it is saved as.
import { element } from '../../../shared/element';
import { wordsOf } from '../../../shared/start';
import { clipNamed } from '../../rig/clips';
import { inFile } from '../../takes/carrying';
import type { Takes } from '../../takes/opening';
import type { Recorder } from '../../takes/video/recording';
import { takeAsCsv } from '../../takes/saving/csv';
import { takeAsGlb } from '../../takes/saving/glb';
import type { Clip, Model } from '../../types/model';
import type { Context, Part } from '../parts/part';
import { createVideo } from './video';

export function createFiles(
  context: Context,
  takes: Takes,
  recorder: Recorder,
): Pick<Part, 'element' | 'show'> {
  const { store, scene, tell } = context;
  const save = (
    words: string,
    title: string,
    suffix: string,
    make: (clip: Clip, model: Model) => Promise<Blob>,
  ) => {
    const made = element('button', { type: 'button', title }, words);
    made.addEventListener('click', () => {
      const state = store.get();
      const model = scene()?.models[state.shown[0] ?? 0];
      const clip = clipNamed(scene()?.models ?? [], state);
      if (!model || !clip) return;
      make(clip, model).then(
        (blob) => {
          download(`${clip.name}.${suffix}`, blob);
          inFile(clip);
        },
        (problem: unknown) => tell(wordsOf(problem)),
      );
    });
    return made;
  };
  const close = element(
    'button',
    { type: 'button', title: 'Take the take off the page, and out of what the browser keeps' },
    'Close take',
  );
  close.addEventListener('click', () => {
    const { takes, clip } = store.get();
    const others = takes.filter(({ name }) => name !== clip);
    store.update({ takes: others, range: null, playing: false });
  });
  return {
    show({ takes, clip }) {
      close.hidden = !takes.some(({ name }) => name === clip);
    },
    element: element(
      'div',
      { class: 'take-files', role: 'group', 'aria-label': 'Files of the take' },
      openButton('Open a take…', takes.acceptsHere, takes.open),
      openButton('Add sound…', 'audio/*,video/*', takes.open),
      save('Save CSV', 'The take as a table of weights', 'csv', async (clip) => takeAsCsv(clip)),
      save('Save GLB', 'The rig with the take as its animation', 'glb', takeAsGlb),
      createVideo(context, recorder, (take, video) => download(`${take}.webm`, video)),
      close,
    ),
  };
}

/** A button for files that it hands on. */
function openButton(
  words: string,
  accept: string,
  take: (files: readonly File[]) => Promise<void>,
): HTMLElement {
  const button = element('button', { type: 'button' }, words);
  button.addEventListener('click', () => {
    const field = element('input', { type: 'file', accept, multiple: true });
    field.addEventListener('change', () => void take([...(field.files ?? [])]));
    field.click();
  });
  return button;
}

/** Gives people a file. */
function download(name: string, content: Blob): void {
  const address = URL.createObjectURL(content);
  const link = element('a', { href: address, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
