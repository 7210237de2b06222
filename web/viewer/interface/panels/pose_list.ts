// The list of poses: walked through by arrow keys, with a picture of each.
import { element, setText } from '../../../shared/element';
import type { NamedPose, ViewState } from '../../types/state';
import type { Context, Part } from '../parts/part';
import { type PoseRow, poseRow } from './pose_row';
import { createPortraits } from './portraits';

const NONE = 'No pose is saved yet. Set the sliders, give the expression a name, and save it.';

export interface PoseList extends Part {
  chosen(): string | null;
  choose(name: string | null): void;
  focus(): void;
  /** Asks for another name of the chosen pose. */
  rename(done: (name: string) => void): void;
}

/** @param load hears which pose somebody wants to see. */
export function createPoseList(context: Context, load: (name: string) => void): PoseList {
  const list = element('ul', { class: 'pose-list', 'aria-label': 'Poses' });
  const none = element('p', { class: 'hint' }, NONE);
  const whole = element('div', { class: 'pose-scroll' }, none, list);
  const portraits = createPortraits(context);
  let rows: PoseRow[] = [];
  let shown: readonly NamedPose[] = [];
  let chosen: string | null = null;

  const mark = () => {
    const known = rows.some(({ pose }) => pose.name === chosen);
    rows.forEach((row, i) => row.choose(known ? row.pose.name === chosen : i === 0));
    if (!known) rows[0]?.element.querySelector('button')?.removeAttribute('aria-current');
  };
  const choose = (name: string | null) => {
    chosen = name;
    mark();
  };
  const current = () => rows.find(({ pose }) => pose.name === chosen);

  list.addEventListener('keydown', (event) => {
    const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (step === undefined || event.altKey || !(event.target instanceof HTMLButtonElement)) return;
    event.preventDefault();
    const at = rows.findIndex(({ element }) => element.contains(event.target as Node));
    const next = rows[Math.min(rows.length - 1, Math.max(0, at + step))];
    choose(next?.pose.name ?? null);
    next?.focus();
  });

  return {
    element: whole,
    chosen: () => current()?.pose.name ?? null,
    choose,
    focus: () => (current() ?? rows[0])?.focus(),
    rename: (done) => current()?.rename(done),
    load: () => portraits.forget(),
    show({ poses }: ViewState) {
      if (poses !== shown) {
        const field = document.activeElement;
        const held = list.contains(field);
        const kept = new Map(rows.map((row) => [keyOf(row.pose), row]));
        const before = rows;
        rows = poses.map((pose) => kept.get(keyOf(pose)) ?? poseRow(pose, () => load(pose.name)));
        const staying = new Set(rows);
        for (const row of before) if (!staying.has(row)) row.leave();
        const elements = rows.map((row) => row.element);
        arrange(list, elements, elements.findIndex((one) => one.contains(field)));
        shown = poses;
        mark();
        if (held && document.activeElement !== field) current()?.focus();
        none.hidden = poses.length > 0;
        setText(none, NONE);
      }
      portraits.show(rows);
    },
  };
}

/** Puts elements in order around the one that stays: moved, it would lose the focus. */
function arrange(list: HTMLElement, elements: readonly HTMLElement[], staying: number): void {
  const first = elements[Math.max(0, staying)];
  if (first && first.parentElement !== list) list.prepend(first);
  for (let i = Math.max(0, staying) + 1; i < elements.length; i += 1) {
    const [before, own] = [elements[i - 1]!, elements[i]!];
    if (before.nextElementSibling !== own) before.after(own);
  }
  for (let i = staying - 1; i >= 0; i -= 1) {
    const [own, behind] = [elements[i]!, elements[i + 1]!];
    if (behind.previousElementSibling !== own) behind.before(own);
  }
}

function keyOf(pose: NamedPose): string {
  return JSON.stringify([pose.name, pose.weights]);
}
