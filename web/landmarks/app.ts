// Puts the page together: the picture, the points beside it, all photographs below it.
import { element, setText } from '../shared/element';
import { keysDialog, listen } from '../shared/keys';
import { createMessages } from '../shared/messages';
import { wordsOf } from '../shared/start';
import { Desk } from './desk';
import { keymap } from './keymap';
import { createFace } from './panels/face';
import { createHeader } from './panels/header';
import { createHints } from './panels/hints';
import { createList, readable } from './panels/list';
import { createStrip } from './panels/strip';
import { rounded } from './picture/pane';
import { PictureStage, type Over } from './picture/stage';
import { fileOf } from './state/document';
import { Guesses } from './state/guesses';
import { Saving } from './state/saving';
import type { Task } from './types/task';
import { nextTheme } from './theme';
import { Viewing } from './viewing';

const STEP = 24; // CSS pixels that an arrow moves the picture by

export function start(root: HTMLElement, task: Task): void {
  const { names, places } = task;
  const desk = new Desk(task);
  const guesses = new Guesses(places);
  const messages = createMessages();
  const viewing = new Viewing((words) => messages.busy(words));
  const saving = new Saving(
    task.save,
    () => fileOf(task, desk.history.marks),
    (problem) => {
      if (problem) messages.tell(problem);
      show();
    },
  );
  const photographs = places.filter(({ kind }) => kind === 'photograph').length;

  const face = createFace(names, (name) => desk.choose(name));
  const hints = createHints(task, () => desk.putRight());
  const list = createList(names, Math.min(task.asked, photographs), (name) => desk.choose(name), (name) => desk.remove(name));
  const strip = createStrip(places, names.length, (number) => desk.go(number));
  const stage = new PictureStage(
    {
      click(x, y, mark) {
        if (mark === null) placeAt(x, y);
        else desk.choose(mark);
      },
      take: (name) => desk.choose(name),
      moveMark(name, x, y) {
        const mark = viewing.pane?.pick(x, y);
        if (mark) desk.move(name, mark, `drag ${name}`);
      },
      drop: () => desk.settle(),
      grab: (x, y) => viewing.pane?.grab(x, y),
      release: () => viewing.pane?.release(),
      drag: (dx, dy, move) => viewing.pane?.drag(dx, dy, move),
      zoom: (factor, x, y) => {
        viewing.pane?.zoom(factor, x, y);
        stage.request();
      },
    },
    over,
  );

  function placeAt(x: number, y: number): void {
    const mark = desk.active === null ? null : viewing.pane?.pick(x, y);
    if (mark) desk.put(mark);
  }

  function over(): Over {
    const { pane } = viewing;
    const { place, active, own } = desk;
    const none = { marks: [], guess: null, lines: [], places: false, missing: false };
    if (!pane) return none;
    const marks = Object.entries(own).flatMap(([name, mark]) => {
      const spot = pane.spot(mark);
      const off = guesses.residual(place, name, desk.history.marks)?.off ?? false;
      const label = name === active || off ? readable(name) : '';
      return spot ? [{ name, spot, label, active: name === active, off }] : [];
    });
    if (active === null) return { ...none, marks };
    const { pixel, line } = guesses.of(place, active, desk.history.marks);
    const guess = pixel && pane.spot({ at: pixel });
    const points = line.flatMap((at) => {
      const spot = pane.spot({ at });
      return spot ? [[spot.x, spot.y] as const] : [];
    });
    const label = own[active] ? '' : readable(active);
    return {
      marks,
      guess: guess && { spot: guess, label },
      lines: points.length > 1 ? [{ points, label }] : [],
      places: true,
      missing: !own[active],
    };
  }

  function show(): void {
    const { place, active, own, history } = desk;
    header.show(history.canUndo, history.canRedo, words());
    face.show(active, (name) => desk.count(name) / desk.asked);
    list.show(
      names.map((name) => {
        const residual = guesses.residual(place, name, history.marks);
        const here = Boolean(own[name]);
        const count = place.kind === 'photograph' ? desk.count(name) : 0;
        return { name, here, count, residual: residual?.pixels ?? null, off: residual?.off ?? false };
      }),
      active,
    );
    list.element.dataset['kind'] = place.kind;
    hints.show(desk, guesses.any);
    strip.show(desk.current, places.map(({ key }) => Object.keys(history.of(key)).length));
    stage.request();
  }

  function words(): string {
    if (task.save === null) return saving.state === 'saved' ? '' : 'not downloaded yet';
    return {
      saved: desk.history.canUndo || desk.history.canRedo ? `saved in ${task.file}` : '',
      changed: 'saving …',
      saving: 'saving …',
      failed: 'not saved',
    }[saving.state];
  }

  let opened = '';
  async function open(): Promise<void> {
    const { place, current } = desk;
    if (place.key === opened) return;
    opened = place.key;
    desk.pointOf = null;
    stage.show(null, place.name);
    try {
      const pane = await viewing.open(place);
      if (!pane) return;
      const { surface } = viewing;
      desk.pointOf = surface && ((vertex) => surface.point(vertex));
      stage.show(pane, `${place.name}: click to place points, or press Enter for one in the middle`);
      viewing.small(current, strip);
      show();
    } catch (error) {
      if (opened === place.key) opened = ''; // whoever asks for it again has it tried again
      messages.tell(wordsOf(error));
    }
  }

  desk.listen((placed) => {
    if (placed) saving.touch();
    show();
    void open();
  });

  const header = createHeader(task.title, task.save !== null, {
    undo: () => desk.undo(),
    redo: () => desk.redo(),
    help: () => dialog.showModal(),
    theme: nextTheme,
    download: () => saving.download(task.file),
    async finish() {
      if (!(await saving.finish())) {
        header.offerDownload();
        return;
      }
      root.replaceChildren(ended(task.file));
    },
  });

  const keys = keymap({
    turnPage: (by) => desk.go(desk.current + by),
    nextPoint: (by) => desk.step(by),
    nextMissing() {
      if (!messages.dismiss()) desk.nextMissing();
    },
    place: () => placeAt(...stage.middle),
    placeGuess() {
      const { place, active, history } = desk;
      const pixel = active === null ? null : guesses.of(place, active, history.marks).pixel;
      if (pixel) desk.put({ at: pixel.map(rounded) });
    },
    remove: () => desk.remove(desk.active),
    undo: () => desk.undo(),
    redo: () => desk.redo(),
    save: () => (task.save === null ? saving.download(task.file) : void saving.save()),
    arrow(dx, dy) {
      const { active, own } = desk;
      const mark = active === null ? undefined : own[active];
      if (!mark) viewing.pane?.drag(-STEP * dx, -STEP * dy, false);
      const moved = mark && viewing.pane?.nudged(mark, dx, dy);
      if (moved) desk.move(active!, moved, `arrow ${active}`);
      stage.request();
    },
    zoom(factor) {
      viewing.pane?.zoom(factor, ...stage.middle);
      stage.request();
    },
    fit() {
      viewing.pane?.fit();
      stage.request();
    },
    actual() {
      viewing.pane?.actual();
      stage.request();
    },
    clay() {
      const { surface } = viewing;
      if (surface) surface.clay = !surface.clay;
      stage.request();
    },
    edges() {
      const { surface } = viewing;
      if (surface) surface.edges = !surface.edges;
      stage.request();
    },
    help: () => dialog.showModal(),
  });
  const dialog = keysDialog(keys);
  listen(keys, stage.element);

  const frame = element('div', { class: 'stage' }, stage.element);
  const panel = element('aside', { class: 'panel', 'aria-label': 'Points' }, face.element, hints.element, hints.warning, list.element);
  root.replaceChildren(header.element, frame, messages.element, panel, strip.element, dialog);
  document.title = `${task.title} – landmarks`;
  show();
  void open().then(() => viewing.fill(places, strip));
}

function ended(file: string): HTMLElement {
  const words = element('p', { class: 'cannot', role: 'status' });
  setText(words, `Saved in ${file}. The command has ended; this page can be closed.`);
  return words;
}
