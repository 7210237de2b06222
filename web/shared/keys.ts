// What each key does, and the list of it.
import { element } from './element';
import { icon } from './icons';

export interface Key {
  /** As `KeyboardEvent.key`. */
  readonly keys: readonly string[];
  /** As on the keyboard. */
  readonly caps: readonly string[];
  readonly words: string;
  /** Only while the picture has the focus. */
  readonly inPicture?: boolean;
  /** Together with Ctrl, or ⌘. */
  readonly ctrl?: boolean;
  run(key: string, shift: boolean): void;
}

/** Runs the keys of the page, but none while somebody types or a control needs the key itself. */
export function listen(keys: readonly Key[], picture: HTMLElement): void {
  let typed: EventTarget | null = null; // the field in which somebody has typed since they came to it
  addEventListener('focusin', () => (typed = null));
  addEventListener('input', ({ target }) => (typed = target));
  addEventListener('keydown', (event) => {
    if (event.defaultPrevented || event.altKey) return;
    if (document.querySelector('dialog[open]')) return; // nothing happens behind it
    const target = event.target instanceof Element ? event.target : null;
    const pressed = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const ctrl = event.ctrlKey || event.metaKey;
    // Nothing of its own can be undone in a field where nobody has typed, nor ever in a list.
    const free = ctrl && (target !== typed || target?.matches('select'));
    if (!free && takes(target, pressed)) return;
    const key = keys.find((one) => one.keys.includes(pressed) && (one.ctrl ?? false) === ctrl);
    if (!key || (key.inPicture && !picture.contains(target))) return;
    event.preventDefault();
    key.run(pressed, event.shiftKey);
  });
}

const TYPED = 'input:not([type=range], [type=checkbox], [type=radio]), textarea, select';
const PRESSED = 'button, input[type=checkbox], input[type=radio], summary, a[href]';

// What has the focus comes first: letters go into fields, the space bar presses buttons.
function takes(target: Element | null, key: string): boolean {
  if (!target) return false;
  if (target.matches(TYPED)) return key !== 'Escape';
  return key === ' ' && target.matches(PRESSED);
}

export function keysDialog(keys: readonly Key[]): HTMLDialogElement {
  const close = element('button', { type: 'button', 'aria-label': 'Close' }, icon('close'));
  const list = element(
    'dl',
    { class: 'keys' },
    ...keys.map(({ caps, words }) =>
      element(
        'div',
        {},
        element('dt', {}, ...caps.map((cap) => element('kbd', {}, cap))),
        element('dd', {}, words),
      ),
    ),
  );
  const dialog = element(
    'dialog',
    { 'aria-labelledby': 'keys-title' },
    element('header', {}, element('h2', { id: 'keys-title' }, 'Keys'), close),
    list,
  );
  close.addEventListener('click', () => dialog.close());
  // Browsers close it a moment after Escape, and a key that is pressed meanwhile would be lost.
  dialog.addEventListener('keydown', (event) => {
    if (event.key !== 'Escape') return;
    event.preventDefault();
    dialog.close();
  });
  dialog.addEventListener('click', (event) => {
    if (event.target === dialog) dialog.close(); // the backdrop
  });
  return dialog;
}
