// What is asked for now, in a sentence or two, and a warning where left and right are exchanged.
import { element, setText } from '../../shared/element';
import type { Desk } from '../desk';
import type { Task } from '../types/task';
import { readable } from './list';

export interface Hints {
  readonly element: HTMLElement;
  readonly warning: HTMLElement;
  show(desk: Desk, cameras: boolean): void;
}

export function createHints({ words, names }: Task, exchange: () => void): Hints {
  const title = element('h2');
  const text = element('p');
  const progress = element('p', { class: 'progress' });
  const warned = element('p');
  const button = element('button', { type: 'button' }, 'Exchange them');
  button.addEventListener('click', exchange);
  const warning = element('div', { class: 'warning', role: 'alert', hidden: true }, warned, button);
  return {
    element: element('div', { class: 'hints' }, title, text, progress),
    warning,
    show(desk, cameras) {
      const { active, place, own, asked } = desk;
      const flat = place.kind === 'photograph';
      const full = names.filter((name) => desk.count(name) >= asked).length;
      if (active === null) {
        setText(title, names.every((name) => own[name]) ? 'All points are here' : 'Nothing more is asked for');
        setText(text, full === names.length ? finished(flat) : GO_ON);
      } else {
        setText(title, own[active] ? `Move: ${readable(active)}` : readable(active));
        const where = words[active] ?? '';
        const more = flat && cameras && !own[active] ? ' The blue mark is where other photographs put it (G).' : '';
        setText(text, `${where ? `${where[0]!.toUpperCase()}${where.slice(1)}.` : ''}${more}`);
      }
      setText(
        progress,
        flat
          ? `${full} of ${names.length} points in ${asked === 1 ? 'the photograph' : `${asked} photographs`}. Leave out what is hidden.`
          : `${full} of ${names.length} points.`,
      );
      const pairs = desk.exchanged;
      warning.hidden = pairs.length === 0;
      if (pairs.length > 0) setText(warned, exchangedWords(pairs.flat(), flat));
    },
  };
}

const GO_ON = 'Go on with another photograph: one from the front and one from either side are best.';

function finished(flat: boolean): string {
  return flat ? 'Every point is in as many photographs as are asked for.' : 'Nothing is missing.';
}

function exchangedWords(names: readonly string[], flat: boolean): string {
  const which = names.map((name) => readable(name)).join(', ');
  const mirrored = flat ? 'the photograph is mirrored' : 'the surface is mirrored';
  return `Left and right are the subject’s own, and seem to be exchanged here, or ${mirrored}: ${which}.`;
}
