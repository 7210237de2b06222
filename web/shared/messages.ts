// Problems, told until they have been read, and what the page is busy with.
import { element, setText } from './element';
import { icon } from './icons';

const MANY = 3; // messages at once
const MOMENT = 3000; // milliseconds, or
const LETTER = 70; // for each letter, where that is longer

export interface Messages {
  readonly element: HTMLElement;
  tell(message: string): void;
  /** Takes away the last message; false where there is none. */
  dismiss(): boolean;
  /** Says for a moment that something is done. */
  say(words: string): void;
  /** Says what takes a while; null when it is done. */
  busy(words: string | null): void;
}

export function createMessages(): Messages {
  const alert = element('div', { role: 'alert', class: 'alerts' });
  const status = element('div', { role: 'status', class: 'busy' });
  const said = element('div', { role: 'status', class: 'busy' });
  let moment: ReturnType<typeof setTimeout> | undefined;
  return {
    element: element('div', { class: 'messages' }, status, said, alert),
    tell(message) {
      const told = [...alert.children].find((one) => one.textContent === message);
      told?.remove();
      const close = element('button', { type: 'button', 'aria-label': 'Dismiss' }, icon('close'));
      const whole = element('div', { class: 'message' }, element('p', {}, message), close);
      close.addEventListener('click', () => whole.remove());
      alert.append(whole);
      while (alert.children.length > MANY) alert.firstElementChild?.remove();
    },
    dismiss() {
      const last = alert.lastElementChild;
      last?.remove();
      return last !== null;
    },
    say(words) {
      setText(said, words);
      clearTimeout(moment);
      moment = setTimeout(() => setText(said, ''), Math.max(MOMENT, LETTER * words.length));
    },
    busy: (words) => setText(status, words ?? ''),
  };
}
