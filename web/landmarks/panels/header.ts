// The line above the picture: what is done, back and on, and the end of it.
import { element, setText } from '../../shared/element';
import { icon } from '../../shared/icons';

export interface HeaderDeeds {
  undo(): void;
  redo(): void;
  help(): void;
  theme(): void;
  download(): void;
  finish(): void;
}

export interface Header {
  readonly element: HTMLElement;
  show(canUndo: boolean, canRedo: boolean, saved: string): void;
  /** Nobody takes the file any more: people can still keep it. */
  offerDownload(): void;
}

/** @param saves whether there is a server that takes what is placed */
export function createHeader(title: string, saves: boolean, deeds: HeaderDeeds): Header {
  const button = (words: string, run: () => void, more = {}, ...content: (Node | string)[]) => {
    const made = element('button', { type: 'button', ...more }, ...content);
    if (content.every((one) => typeof one !== 'string')) made.setAttribute('aria-label', words);
    made.title = words;
    made.addEventListener('click', run);
    return made;
  };
  const undo = button('Undo (Ctrl Z)', deeds.undo, {}, 'Undo');
  const redo = button('Redo (Ctrl Shift Z)', deeds.redo, {}, 'Redo');
  const status = element('span', { class: 'saved', role: 'status' });
  const keep = button('Download the file', deeds.download, {}, 'Download');
  const end = saves ? button('Save, and end the command', deeds.finish, {}, 'Finish') : keep;
  end.className = 'primary';
  return {
    element: element(
      'header',
      { class: 'head' },
      element('h1', { title }, title),
      status,
      undo,
      redo,
      button('Light or dark', deeds.theme, { 'aria-label': 'Light or dark' }, '◐'),
      button('Keys (?)', deeds.help, {}, icon('help')),
      end,
    ),
    offerDownload() {
      if (!keep.isConnected) end.before(keep);
    },
    show(canUndo, canRedo, saved) {
      undo.disabled = !canUndo;
      redo.disabled = !canRedo;
      setText(status, saved);
    },
  };
}
