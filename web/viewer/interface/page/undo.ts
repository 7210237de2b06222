// The buttons that undo and redo.
import { element } from '../../../shared/element';
import { icon } from '../../../shared/icons';
import type { Part } from '../parts/part';
import type { History } from '../state/history';

export function createUndo(history: History): Part {
  const button = (drawing: 'undo' | 'redo', words: string, keys: string) => {
    const made = element('button', {
      type: 'button',
      title: `${words} (${keys.replace('Control', 'Ctrl')})`,
      'aria-label': words,
      'aria-keyshortcuts': keys,
      onclick: () => history[drawing](),
    });
    made.append(icon(drawing));
    return made;
  };
  const undo = button('undo', 'Undo', 'Control+Z');
  const redo = button('redo', 'Redo', 'Control+Shift+Z');
  return {
    element: element('div', { class: 'undo', role: 'group', 'aria-label': 'History' }, undo, redo),
    show() {
      undo.disabled = !history.canUndo();
      redo.disabled = !history.canRedo();
    },
  };
}
