// What is done to the chosen pose, by buttons below the list and by keys in it.
import { element } from '../../../shared/element';
import { type Icon, icon } from '../../../shared/icons';
import type { Part } from '../parts/part';
import type { Deeds } from '../poses/deeds';
import type { PoseList } from './pose_list';

export function createPoseTools(deeds: Deeds, list: PoseList): Part {
  const onChosen = (run: (name: string) => void) => () => {
    const name = list.chosen();
    if (name !== null) run(name);
  };
  const acts = {
    rename: onChosen((name) =>
      list.rename((text) => {
        if (deeds.rename(name, text)) list.focus();
      }),
    ),
    duplicate: onChosen(deeds.duplicate),
    up: onChosen((name) => deeds.move(name, -1)),
    down: onChosen((name) => deeds.move(name, 1)),
    copy: onChosen((name) => void deeds.copy(name)),
    remove: onChosen(deeds.remove),
  };
  const [up, down] = [
    tool('up', 'Move up', 'Alt+↑', acts.up),
    tool('down', 'Move down', 'Alt+↓', acts.down),
  ];
  const tools = [
    tool('rename', 'Rename', 'F2', acts.rename),
    tool('duplicate', 'Duplicate', 'Ctrl+D', acts.duplicate),
    ...[up, down],
    tool('copy', 'Copy as text', 'Ctrl+C', acts.copy),
    tool('remove', 'Delete', 'Delete', acts.remove),
  ];
  list.element.addEventListener('keydown', (event) => {
    if (!(event.target instanceof HTMLButtonElement)) return;
    const act = actOf(event);
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    acts[act]();
    if (act !== 'rename' && act !== 'copy') list.focus();
  });
  return {
    element: element(
      'div',
      { class: 'pose-tools', role: 'toolbar', 'aria-label': 'The chosen pose' },
      ...tools,
    ),
    show({ poses }) {
      const place = poses.findIndex(({ name }) => name === list.chosen());
      for (const one of tools) one.disabled = place < 0;
      up.disabled ||= place === 0;
      down.disabled ||= place === poses.length - 1;
    },
  };
}

function actOf({ key, ctrlKey, metaKey, altKey }: KeyboardEvent) {
  if (altKey) return key === 'ArrowUp' ? 'up' : key === 'ArrowDown' ? 'down' : null;
  if (ctrlKey || metaKey)
    return key.toLowerCase() === 'c' ? 'copy' : key.toLowerCase() === 'd' ? 'duplicate' : null;
  return key === 'F2' ? 'rename' : key === 'Delete' ? 'remove' : null;
}

function tool(drawing: Icon, words: string, keys: string, run: () => void): HTMLButtonElement {
  const made = element('button', {
    type: 'button',
    'aria-label': words,
    title: `${words} (${keys} in the list)`,
    onclick: run,
  });
  made.append(icon(drawing));
  return made;
}
