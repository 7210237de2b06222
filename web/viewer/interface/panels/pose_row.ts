// One pose of the list: its picture, its name, and what moves most in it.
import { element, setAttribute } from '../../../shared/element';
import type { NamedPose } from '../../types/state';

const TOLD = 3; // sliders

export interface PoseRow {
  readonly pose: NamedPose;
  readonly element: HTMLElement;
  choose(chosen: boolean): void;
  focus(): void;
  picture(drawn: HTMLCanvasElement): void;
  /** Puts a field in the place of the name; `done` hears the new one, and whether it was meant. */
  rename(done: (name: string) => void): void;
  /** The row goes, with whatever is being typed in it. */
  leave(): void;
}

export function poseRow(pose: NamedPose, load: () => void): PoseRow {
  const frame = element('span', { class: 'portrait', 'aria-hidden': 'true' });
  const name = element('span', { class: 'pose-name' }, pose.name);
  const words = element('span', { class: 'pose-words' }, wordsOf(pose));
  const button = element(
    'button',
    { type: 'button', class: 'pose', 'data-pose': pose.name, title: pose.name },
    frame,
    element('span', { class: 'pose-text' }, name, words),
  );
  // A double click is meant as one: a part of the pose is not taken twice.
  button.addEventListener('click', ({ detail }) => detail < 2 && load());
  const whole = element('li', {}, button);
  let over = true; // no new name is being typed
  return {
    pose,
    element: whole,
    choose(chosen) {
      setAttribute(button, 'aria-current', chosen && 'true');
      button.tabIndex = chosen ? 0 : -1;
    },
    focus: () => button.focus(),
    picture: (drawn) => frame.replaceChildren(drawn),
    rename(done) {
      const field = element('input', {
        type: 'text',
        value: pose.name,
        'aria-label': `New name of ${pose.name}`,
      });
      over = false;
      const end = (name: string) => {
        if (over) return;
        over = true;
        const held = document.activeElement === field;
        field.remove();
        button.hidden = false;
        if (held) button.focus();
        done(name);
      };
      field.addEventListener('keydown', (event) => {
        if (event.key !== 'Enter' && event.key !== 'Escape') return;
        event.stopPropagation();
        end(event.key === 'Enter' ? field.value : pose.name);
      });
      field.addEventListener('blur', () => end(field.value));
      button.hidden = true;
      whole.append(field);
      field.focus();
      field.select();
    },
    leave() {
      over = true;
      whole.remove();
    },
  };
}

function wordsOf({ weights }: NamedPose): string {
  const moving = Object.entries(weights).sort(([, a], [, b]) => Math.abs(b) - Math.abs(a));
  if (moving.length === 0) return 'neutral';
  const told = moving.slice(0, TOLD).map(([slider, weight]) => `${slider} ${weight.toFixed(2)}`);
  const rest = moving.length - told.length;
  return [...told, ...(rest > 0 ? [`${rest} more`] : [])].join(' · ');
}
