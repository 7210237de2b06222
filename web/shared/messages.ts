// Problems, told until they have been read, and what the page is busy with.
import { element, setText } from './element';
import { icon } from './icons';

const MANY = 3; // messages at once

export interface Messages {
  readonly element: HTMLElement;
  tell(message: string): void;
  /** Takes away the last message; false where there is none. */
  dismiss(): boolean;
  /** Says what takes a while; null when it is done. */
  busy(words: string | null): void;
}

export function createMessages(): Messages {
  const alert = element('div', { role: 'alert', class: 'alerts' });
  const status = element('div', { role: 'status', class: 'busy' });
  return {
    element: element('div', { class: 'messages' }, status, alert),
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
    busy: (words) => setText(status, words ?? ''),
  };
}
