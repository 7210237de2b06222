// The tab of poses: save, find again, blend, order, and carry elsewhere.
import { element, setText } from '../../../shared/element';
import type { ViewState } from '../../types/state';
import type { Context, Part } from '../parts/part';
import { poseDeeds } from '../poses/deeds';
import { cleanName, LONGEST_NAME } from '../poses/list';
import { looksLikePoses } from '../poses/text';
import type { Opener } from '../page/opening';
import { createPoseList } from './pose_list';
import { createMixing } from './pose_mixing';
import { createPoseTools } from './pose_tools';

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
  const tools = createPoseTools(deeds, list);

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
    if (document.activeElement === field) list.focus(); // so that keys are those of the page again
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
    if (!text || !context.scene()) return;
    if (target !== field && target?.matches('input, textarea')) return;
    if (target === field && !looksLikePoses(text)) return;
    event.preventDefault();
    deeds.takeText(text);
  });

  const show = (state: ViewState) => {
    list.show(state);
    const known = state.poses.some(({ name }) => name === cleanName(field.value));
    setText(save, known ? 'Replace' : 'Save');
    tools.show(state);
    json.disabled = table.disabled = state.poses.length === 0;
  };

  return {
    element: element(
      'div',
      { class: 'poses' },
      element(
        'div',
        { class: 'scroll' },
        element('div', { class: 'pose-head' }, form, mixing.element),
        list.element,
      ),
      tools.element,
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

function isPoses({ name, type }: File): boolean {
  return /\.json$/i.test(name) || type === 'application/json';
}

function button(words: string, title: string, run: () => void): HTMLButtonElement {
  return element('button', { type: 'button', title, onclick: run }, words);
}
