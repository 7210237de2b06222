// The tab of poses: save, find again, blend, order, and carry elsewhere.
import { element, setText } from '../../../shared/element';
import { type Icon, icon } from '../../../shared/icons';
import type { ViewState } from '../../types/state';
import { fill } from '../parts/controls';
import type { Context, Part } from '../parts/part';
import { poseDeeds } from '../poses/deeds';
import { cleanName, LONGEST_NAME } from '../poses/list';
import { looksLikePoses } from '../poses/text';
import type { Opener } from '../page/opening';
import { createPoseList } from './pose_list';

const FILES = '.json,application/json';

export interface PosesPanel extends Part {
  /** Asks for the name of a pose to save. */
  name(): void;
  /** What opens files of poses. */
  readonly opener: Opener;
}

/** @param open asks for files. */
export function createPoses(context: Context, open: () => void): PosesPanel {
  const { store } = context;
  const deeds = poseDeeds(context, (name) => {
    list.show(store.get());
    list.choose(name);
    show(store.get());
  });
  const mixing = createMixing((strength, onTop) => deeds.blend(strength, onTop));
  const list = createPoseList(context, (name) => {
    deeds.load(name, mixing.strength(), mixing.onTop());
  });
  const onChosen = (run: (name: string) => void) => () => {
    const name = list.chosen();
    if (name !== null) run(name);
  };
  const rename = onChosen((name) =>
    list.rename((text) => {
      if (deeds.rename(name, text)) list.focus();
    }),
  );
  const acts = {
    rename,
    duplicate: onChosen((name) => deeds.duplicate(name)),
    up: onChosen((name) => deeds.move(name, -1)),
    down: onChosen((name) => deeds.move(name, 1)),
    copy: onChosen((name) => void deeds.copy(name)),
    remove: onChosen((name) => deeds.remove(name)),
  };
  const tools = [
    tool('rename', 'Rename', 'F2', acts.rename),
    tool('duplicate', 'Duplicate', 'Control+D', acts.duplicate),
    tool('up', 'Move up', 'Alt+ArrowUp', acts.up),
    tool('down', 'Move down', 'Alt+ArrowDown', acts.down),
    tool('copy', 'Copy as text', 'Control+C', acts.copy),
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

  const field = element('input', {
    type: 'text',
    placeholder: 'Name of the pose',
    'aria-label': 'Name of the pose',
    'aria-keyshortcuts': 'P',
    maxlength: LONGEST_NAME,
    autocomplete: 'off',
    spellcheck: 'false',
  });
  const save = element('button', { type: 'submit' }, 'Save');
  const form = element('form', { class: 'pose-save' }, field, save);
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    deeds.save(field.value);
    field.value = '';
    show(store.get());
  });
  field.addEventListener('input', () => show(store.get()));

  const [json, table] = [
    button('JSON', 'Save all poses as JSON', () => deeds.saveJson()),
    button('CSV', 'Save all poses as a table', () => deeds.saveTable()),
  ];
  addEventListener('paste', (event) => {
    const target = event.target instanceof Element ? event.target : null;
    const text = event.clipboardData?.getData('text') ?? '';
    if (!context.scene() || (target !== field && target?.matches('input, textarea'))) return;
    if (target === field && !looksLikePoses(text)) return;
    event.preventDefault();
    deeds.takeText(text);
  });

  const show = (state: ViewState) => {
    list.show(state);
    const known = state.poses.some(({ name }) => name === cleanName(field.value));
    setText(save, known ? 'Replace' : 'Save');
    const place = state.poses.findIndex(({ name }) => name === list.chosen());
    tools.forEach((one) => (one.disabled = place < 0));
    if (place === 0) tools[2]!.disabled = true;
    if (place === state.poses.length - 1) tools[3]!.disabled = true;
    json.disabled = table.disabled = state.poses.length === 0;
  };

  return {
    element: element(
      'div',
      { class: 'poses' },
      element('div', { class: 'pose-head' }, form, mixing.element),
      list.element,
      element(
        'div',
        { class: 'pose-tools', role: 'toolbar', 'aria-label': 'The chosen pose' },
        ...tools,
      ),
      element(
        'div',
        { class: 'pose-foot' },
        button('Paste', 'Paste poses from the clipboard', () => void deeds.paste()),
        button('Open…', 'Open poses from files', open),
        element('span', { class: 'of-saving' }, element('span', {}, 'All as'), json, table),
      ),
    ),
    show,
    load: (scene) => list.load?.(scene),
    opener: { accepts: FILES, fits: (files) => files.filter(isPoses), open: deeds.open },
    name() {
      field.focus();
      field.select();
    },
  };
}

/** How much of a pose is taken. */
function createMixing(changed: (strength: number, onTop: boolean) => void) {
  const range = element('input', {
    type: 'range',
    'aria-label': 'Strength of the pose',
    min: 0,
    max: 1,
    step: 0.01,
    value: 1,
  });
  const value = element('span', { class: 'value', 'aria-hidden': 'true' }, '100 %');
  const box = element('input', { type: 'checkbox' });
  const tell = () => {
    const percent = `${Math.round(100 * range.valueAsNumber)} %`;
    fill(range, 0, range.valueAsNumber);
    setText(value, percent);
    range.setAttribute('aria-valuetext', percent);
    changed(range.valueAsNumber, box.checked);
  };
  for (const input of [range, box]) input.addEventListener('input', tell);
  fill(range, 0, 1);
  return {
    element: element(
      'div',
      { class: 'pose-mixing' },
      element('span', { 'aria-hidden': 'true' }, 'Strength'),
      range,
      value,
      element('label', { class: 'check', title: 'Add the pose to the present one' }, box, 'On top'),
    ),
    strength: () => range.valueAsNumber,
    onTop: () => box.checked,
  };
}

function isPoses({ name, type }: File): boolean {
  return /\.json$/i.test(name) || type === 'application/json';
}

function actOf({ key, ctrlKey, metaKey, altKey }: KeyboardEvent) {
  if (altKey) return key === 'ArrowUp' ? 'up' : key === 'ArrowDown' ? 'down' : null;
  if (ctrlKey || metaKey)
    return key.toLowerCase() === 'c' ? 'copy' : key.toLowerCase() === 'd' ? 'duplicate' : null;
  return key === 'F2' ? 'rename' : key === 'Delete' ? 'remove' : null;
}

function button(words: string, title: string, run: () => void): HTMLButtonElement {
  return element('button', { type: 'button', title, onclick: run }, words);
}

function tool(drawing: Icon, words: string, keys: string, run: () => void): HTMLButtonElement {
  const told = keys.replace('Control', 'Ctrl').replace('Arrow', '');
  const made = element('button', {
    type: 'button',
    'aria-label': words,
    title: `${words} (${told} in the list)`,
    onclick: run,
  });
  made.append(icon(drawing));
  return made;
}
