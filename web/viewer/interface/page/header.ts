// The line above the picture: what is shown, from where, and what can be opened.
import type { View } from '../../types/stage';
import { element, setAttribute, setText } from '../../../shared/element';
import { type Icon, icon } from '../../../shared/icons';
import { VIEWS } from './keymap';

export interface Header {
  readonly element: HTMLElement;
  title(words: string): void;
  panelIsOpen(open: boolean): void;
  /** Whether folders can be opened. */
  folders(can: boolean): void;
}

export interface HeaderDeeds {
  look(view: View): void;
  open(): void;
  openFolder(): void;
  help(): void;
  panel(): void;
}

/** @param undo buttons that stand among the tools. */
export function createHeader(deeds: HeaderDeeds, undo: HTMLElement): Header {
  const title = element('h1', {}, 'elastomorph');
  const views = VIEWS.map(([view, words], i) => {
    const label = `View from ${view === 'three-quarter' ? 'three-quarter' : `the ${view}`}`;
    const button = element(
      'button',
      {
        type: 'button',
        'aria-keyshortcuts': String(i + 1),
        'aria-label': view === 'three-quarter' ? '¾ view' : null,
        title: view === 'below' ? 'View from below' : label,
      },
      words,
    );
    button.addEventListener('click', () => deeds.look(view));
    return button;
  });
  const open = tool('open', 'Open a GLB…', deeds.open);
  const folder = tool('folder', 'Open a folder of meshes…', deeds.openFolder);
  folder.hidden = true;
  const help = tool('help', 'Keys (?)', deeds.help);
  const panel = tool('panel', 'Panel', deeds.panel);
  return {
    element: element(
      'header',
      { class: 'head' },
      title,
      element('div', { class: 'views', role: 'group', 'aria-label': 'Views' }, ...views),
      element('div', { class: 'tools' }, undo, open, folder, help, panel),
    ),
    title(words) {
      setText(title, words || 'elastomorph');
      title.title = words;
      document.title = words ? `${words} – elastomorph` : 'elastomorph';
    },
    folders: (can) => {
      folder.hidden = !can;
    },
    panelIsOpen: (isOpen) => setAttribute(panel, 'aria-expanded', String(isOpen)),
  };
}

function tool(drawing: Icon, words: string, run: () => void): HTMLButtonElement {
  const button = element('button', { type: 'button', 'aria-label': words, title: words });
  button.append(icon(drawing));
  button.addEventListener('click', run);
  return button;
}
