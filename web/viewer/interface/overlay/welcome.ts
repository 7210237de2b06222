// What a page without a face says.
import { element } from '../../../shared/element';
import { icon } from '../../../shared/icons';

export function createWelcome(open: () => void): HTMLElement {
  const button = element('button', { type: 'button', class: 'primary' });
  button.append(icon('open'), 'Open a GLB…');
  button.addEventListener('click', open);
  return element(
    'div',
    { class: 'welcome' },
    element('h1', {}, 'elastomorph'),
    element(
      'p',
      {},
      'Shows faces whose expressions move along curved, elastic paths, and compares them with ' +
        'straight ones and with recordings. It opens rigs written by elastomorph and any glTF ' +
        'binary with morph targets; nothing leaves this computer.',
    ),
    button,
    element('p', { class: 'hint' }, 'or drop files anywhere on this page'),
  );
}
