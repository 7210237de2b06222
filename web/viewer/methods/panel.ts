// Methods: the path of each target, another one beside it, and settings that keep the choice.
import { numberOf, ownOf } from '../../shared/named';
import type { Model, Scene } from '../types/model';
import type { ViewState } from '../types/state';
import { element, freshId, setText } from '../../shared/element';
import { wordsOf } from '../../shared/start';
import type { Context, Part } from '../interface/parts/part';
import { isAborted } from './asking';
import { Bench, type Row, type Tried } from './bench';
import { createBeside } from './beside';
import { figuresOf } from './figures';
import { methodPicker } from './picker';
import { targetTable } from './table';

const NOT_SERVED =
  'Methods are chosen where the command line shows a rig: elastomorph view FOLDER.';
const NOT_KEPT =
  'Choices are kept in the elastomorph.toml of a folder: put this rig into one, run ' +
  'elastomorph init FOLDER, then elastomorph view FOLDER.';
const STRAIGHT = 'linear';

/** @param replace shows a scene; `added` are the numbers of its models that were not there. */
export function createMethods(
  context: Context,
  replace: (scene: Scene, added: readonly number[]) => void,
): Part {
  const { store, scene, tell } = context;
  const beside = createBeside(context, replace);
  let subject: Model | null = null; // the rig itself
  let bench: Bench | null = null;
  let rows: readonly Row[] = [];
  let target = '';
  let asked = ''; // what stands beside the rig, or is on its way there
  let tried: Tried | null = null; // what was chosen, once it is there
  let waiting = new AbortController();
  let drawn: readonly unknown[] = [];

  const status = element('p', { class: 'hint', role: 'status' });
  const figures = element('div');
  const straight = element('input', { type: 'checkbox', role: 'switch', id: freshId('line') });
  const save = element('button', { type: 'button', class: 'primary' }, 'Save');
  const back = element('button', { type: 'button' }, 'Take back');
  const kept = element('p', { class: 'hint' }, NOT_KEPT);
  const picker = methodPicker((method) => choose(method));
  const table = targetTable((name) => {
    target = name;
    store.update(posed(store.get(), name));
    show(store.get());
  });
  const line = element('label', { for: straight.id }, 'The straight line beside it');
  const body = element(
    'div',
    { hidden: true },
    element(
      'section',
      { class: 'block' },
      picker.element,
      element('div', { class: 'row toggle' }, line, straight),
      figures,
      element('div', { class: 'buttons' }, save, back),
      kept,
    ),
    table.element,
  );
  const whole = element('div', { class: 'methods' }, status, body);

  const says = (words: string) => setText(status, `${words}…`);
  const rowOf = (name: string) => rows.find((row) => row.name === name);

  const choose = (method: string | null) => {
    const { [target]: _, ...others } = store.get().methods;
    const methods = method === null ? others : { ...others, [target]: method };
    store.update({ methods, ...posed(store.get(), target) });
  };

  const list = async () => {
    const found = scene();
    const base = found?.models[0];
    if (bench || !base || !found.services.methods) return;
    const mine = new Bench(found.services, base);
    bench = mine;
    says('Reading the rig');
    try {
      const listed = await mine.list(says);
      if (bench !== mine) return;
      rows = listed.rows;
      target = rows.find(({ name }) => numberOf(store.get().weights, name))?.name ?? rows[0]?.name ?? '';
      picker.offer(listed.methods);
      setText(status, rows.length > 0 ? '' : 'This rig has no targets.');
      body.hidden = rows.length === 0;
    } catch (error) {
      if (bench === mine) bench = null;
      setText(status, wordsOf(error));
    }
    show(store.get());
  };

  /** Puts what is chosen for the target beside the rig; what was under way for others ends. */
  const compare = async (maker: Bench) => {
    const method = ownOf(store.get().methods, target);
    const key = JSON.stringify([target, method ?? null, straight.checked]);
    if (key === asked) return;
    asked = key;
    waiting.abort();
    waiting = new AbortController();
    const { signal } = waiting;
    tried = null;
    try {
      const line = straight.checked ? [STRAIGHT] : [];
      const wanted = new Set(method === undefined ? line : [method, ...line]);
      const found: Tried[] = [];
      for (const each of wanted) found.push(await maker.try(target, each, says, signal));
      if (signal.aborted) return;
      if (wanted.size > 0) setText(status, '');
      tried = method === undefined ? null : found[0]!;
      for (const words of tried?.warnings ?? []) tell(words);
      beside.put(found.map(({ model }) => ({ ...model, name: titled(target, model.name) })));
    } catch (error) {
      if (isAborted(error)) return;
      tell(wordsOf(error));
      // What cannot be made is not chosen, and what was there stays.
      if (method !== undefined) choose(null);
      setText(status, '');
    }
    show(store.get());
  };

  const keep = async (maker: Bench, base: Model) => {
    const choices = store.get().methods;
    const names = Object.keys(choices);
    const known = Object.fromEntries(names.map((name) => [name, rowOf(name)?.said ?? '']));
    save.disabled = true;
    drawn = [];
    try {
      const saved = await maker.save(choices, known, base, says);
      rows = rows.map((row) => saved.rows.find(({ name }) => name === row.name) ?? row);
      store.update({ methods: {} });
      subject = saved.model;
      beside.rebase(saved.model);
      setText(status, `Written to ${saved.file}`);
    } catch (error) {
      setText(status, '');
      tell(wordsOf(error));
    }
    show(store.get());
  };

  save.addEventListener('click', () => {
    if (bench && subject) void keep(bench, subject);
  });
  back.addEventListener('click', () => store.update({ methods: {} }));
  straight.addEventListener('change', () => show(store.get()));
  // The first look at the tab reads the rig: those who never look do not wait for it.
  new IntersectionObserver((seen) => {
    if (seen.some(({ isIntersecting }) => isIntersecting)) void list();
  }).observe(whole);

  const show = (state: ViewState) => {
    const row = rowOf(target);
    if (!bench || !row) return;
    void compare(bench);
    // While a face moves this is asked at every frame.
    const now = [rows, target, state.methods, tried, bench, subject];
    if (now.every((one, i) => one === drawn[i])) return;
    drawn = now;
    picker.show(row, ownOf(state.methods, target) ?? null);
    const made = (name: string) => bench?.known(name, ownOf(state.methods, name)!);
    table.show(rows, state.methods, made, target);
    const found = scene();
    const diameter = found?.models[0]?.diameter ?? 0;
    figures.replaceChildren(figuresOf(row, tried?.row ?? null, found?.unit ?? '', diameter));
    const count = Object.keys(state.methods).length;
    const may = found?.services.save !== undefined;
    setText(save, count > 1 ? `Save all ${count}` : 'Save');
    save.disabled = count === 0 || !may;
    back.disabled = count === 0;
    kept.hidden = may;
  };

  return {
    element: whole,
    load(found) {
      const rig = found?.models[0] ?? null;
      if (rig !== null && rig === subject) return;
      [subject, bench, rows, tried, asked] = [rig, null, [], null, ''];
      waiting.abort();
      body.hidden = true;
      setText(status, found?.services.methods ? '' : NOT_SERVED);
    },
    show,
  };
}

/** The target alone, half way, where paths differ most: unless it is in sight already. */
function posed({ weights, clip }: ViewState, target: string): Partial<ViewState> {
  if (clip === null && numberOf(weights, target)) return {};
  return { weights: { [target]: 1 }, t: 0.5, clip: null, playing: false };
}

function titled(target: string, method: string): string {
  const words = method === STRAIGHT ? 'straight line' : method || 'without its own';
  return `${target}: ${words}`;
}
