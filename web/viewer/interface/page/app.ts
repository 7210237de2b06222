// Puts the page together: the picture, what lies over it, the panels, and the one state of all.
import type { Clip, Scene } from '../../types/model';
import type { Readout, Stage, View } from '../../types/stage';
import type { ViewState } from '../../types/state';
import { createGrab } from '../../grab/tool';
import { createLabels } from '../overlay/labels';
import { createLegend } from '../overlay/legend';
import { createMessages } from '../../../shared/messages';
import { createPointer } from '../overlay/pointer';
import { createSwipe } from '../overlay/swipe';
import { createWelcome } from '../overlay/welcome';
import { createCompare } from '../panels/compare';
import { createDisplay, frameWords } from '../panels/display';
import { createHeat } from '../panels/heat';
import { createOrbits } from '../panels/orbits';
import { createPoses } from '../panels/poses';
import { createSliders } from '../panels/sliders';
import { createTimeline, mark } from '../timeline/timeline';
import { askBeforeLeaving, goingOn } from '../../takes/carrying';
import { createKeeper } from '../../takes/keeping/keeper';
import { opened, takesOpener } from '../../takes/opening';
import { createRecorder } from '../../takes/video/recording';
import { createSpeaker } from '../../takes/sound';
import { createTabs } from '../panels/tabs';
import { createTransport } from '../panels/transport';
import { createLive } from '../../live/live';
import { element, setText } from '../../../shared/element';
import type { Context, Part } from '../parts/part';
import { createKept } from '../state/kept';
import { createHistory } from '../state/history';
import { INITIAL, startOf } from '../state/initial';
import { createPlayer } from '../state/player';
import { settling } from '../state/settling';
import { createStore, type Store } from '../state/store';
import { createHeader } from './header';
import { keymap } from './keymap';
import { keysDialog, listen } from '../../../shared/keys';
import { joins, modelOpener } from './models';
import { createLink } from './link';
import { createOpening } from './opening';
import { servedOpener } from './served';
import { followTheme, isDark } from './theme';
import { createUndo } from './undo';
import { createMethods } from '../../methods/panel';

const BETWEEN_READOUTS = 200; // milliseconds: figures that flicker cannot be read
const UNTIL_QUIET = 1000; // milliseconds: when there is no frame rate any more

export interface App {
  readonly store: Store;
  readonly stage: Stage;
  scene(): Scene | null;
  show(scene: Scene): Promise<void>;
  look(view: View): void;
  tell(message: string): void;
  busy(words: string | null): void;
}

export function createApp(root: HTMLElement, stageIn: (picture: HTMLElement) => Stage): App {
  let scene: Scene | null = null;
  const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
  const embedded = window.self !== window.top; // in a report or a notebook
  const models = () => scene?.models ?? [];
  const messages = createMessages();
  const picture = element('div', {
    class: 'picture',
    tabindex: 0,
    role: 'application',
    'aria-roledescription': '3D view',
    'aria-label': 'The face. Arrow keys turn it, plus and minus bring it nearer and farther',
  });
  const frame = element('div', { class: 'stage' }, picture);
  root.append(frame);

  const stage = stageIn(picture);
  const store = createStore(INITIAL, settling(models));
  const history = createHistory(store);
  const speaker = createSpeaker();
  const player = createPlayer(store, models, speaker);
  const context: Context = { store, stage, scene: () => scene, ...messages };

  const sliders = createSliders(context);
  const poses = createPoses(context, () => opening.ask());
  const display = createDisplay(context);
  const legend = createLegend(context);
  const pointer = createPointer(context, picture);
  const swipe = createSwipe(context);
  const labels = createLabels(context);
  const [compare, heat, orbits] = [
    createCompare(context),
    createHeat(context),
    createOrbits(context),
  ];
  const takes = takesOpener(context, speaker, (file) => poses.opener.open([file]));
  const recorder = createRecorder(context, speaker, picture, isDark);
  const timeline = createTimeline(context, speaker, takes, recorder, () => {
    if (innerWidth <= 720) tabs.open(false); // a sheet and a timeline leave no picture
  });
  const transport = createTransport(context, player, timeline);
  const live = createLive(context);
  transport.element.prepend(live.element);
  const undo = createUndo(history);
  const grab = createGrab(context, picture, sliders.moved);
  const replace = (next: Scene, added: readonly number[], came: readonly Clip[] = []) => {
    return joins(scene, next.models[0]) ? join(next, added, came) : show(next);
  };
  const methods = createMethods(context, replace);
  const link = createLink(context);
  const kept = createKept(store, history, () => (embedded ? '' : link.words()), messages.tell);
  const keeper = createKeeper(store, speaker, messages.tell);
  const parts: Part[] = [
    ...[sliders, poses, compare, heat, orbits, methods, display, transport, live],
    ...[labels, swipe, legend, pointer, undo, grab],
  ];

  const look = (view: View) => {
    stage.look(view);
    measure();
  };
  const receiver = { scene: () => scene, replace };
  const [served, faces] = [servedOpener(receiver, messages.busy), modelOpener(receiver)];
  // A face before what plays on it, where both are dropped; what nobody knows is refused as a face.
  const first = { ...faces, fits: (files: readonly File[]) => faces.fits(files.filter(isGlb)) };
  const opening = createOpening([served, first, takes, poses.opener, faces], messages);
  const help = () => {
    if (!keys.open) keys.showModal();
  };
  const header = createHeader(
    {
      look,
      help,
      open: opening.ask,
      openFolder: opening.askForFolder,
      panel: () => tabs.open(!tabs.isOpen()),
    },
    undo.element,
  );
  const tabs = createTabs(
    [
      { name: 'Sliders', content: sliders.element },
      { name: 'Poses', content: poses.element },
      { name: 'Compare', content: block(compare, heat, orbits) },
      { name: 'Methods', content: methods.element },
      { name: 'Display', content: block(display, link) },
    ],
    (open) => {
      poses.show(store.get());
      root.dataset.panel = open ? 'open' : 'closed';
      header.panelIsOpen(open);
    },
  );
  const map = keymap(context, player, {
    history,
    look,
    help,
    search: () => {
      tabs.select('Sliders');
      sliders.search();
    },
    swap: sliders.swap,
    draw: sliders.draw,
    star: sliders.star,
    link: link.copy,
    savePose: () => {
      tabs.select('Poses');
      poses.name();
    },
    grab,
    mark: (end) => mark(context, end),
    timeline: timeline.toggle,
    close: () => messages.dismiss() || sliders.clearSearch() || grab.leave(),
  });
  const keys = keysDialog(map);
  listen(map, picture);

  const status = element('div', { class: 'status', 'aria-hidden': 'true' });
  frame.append(
    labels.element,
    swipe.element,
    grab.element,
    status,
    pointer.element,
    createWelcome(opening.ask),
  );
  root.prepend(header.element);
  root.append(legend.element, transport.element, tabs.element);
  root.append(messages.element, opening.element, keys);

  const write = (found: Readout) => {
    display.readout(found);
    legend.readout(found.heat);
    const targets = `${found.targets} ${found.targets === 1 ? 'target' : 'targets'}`;
    const figures = [frameWords(found), targets, `${found.mebibytes.toFixed(1)} MiB`];
    const { playing, clip, weights } = store.get();
    const idle = playing && clip === null && Object.keys(weights).length === 0;
    const hint = idle ? 'no slider is active, so t moves nothing' : '';
    setText(status, [...figures, grab.words() || pointer.words(), hint].filter(Boolean).join(' · '));
  };
  const measure = spaced(() => scene && write(stage.readout()), BETWEEN_READOUTS);
  let quiet: ReturnType<typeof setTimeout> | undefined;

  let awaited = false;
  const draw = () => {
    if (scene) stage.show(store.get());
    if (awaited) return;
    awaited = true;
    requestAnimationFrame(() => {
      awaited = false;
      for (const part of parts) part.show(store.get());
      measure();
      clearTimeout(quiet);
      quiet = setTimeout(measure, UNTIL_QUIET);
    });
  };

  // Throws, with everything as it was, where the stage cannot show the models.
  const replaceScene = (next: Scene, start: Partial<ViewState>) => {
    const before = scene;
    try {
      stage.setModels(next.models);
    } catch (error) {
      if (before) stage.setModels(before.models);
      throw error;
    }
    const fresh = next.models.filter((model) => !before?.models.includes(model));
    fresh.flatMap(({ notes }) => notes).forEach(messages.tell);
    scene = next;
    root.dataset.empty = 'false';
    header.title(next.title);
    header.folders(next.services.open !== undefined);
    for (const part of parts) part.load?.(next);
    history.aside(start);
    draw();
  };
  const show = async (next: Scene) => {
    const own = startOf(next, still, messages.tell);
    const held = await keeper.of(next, own);
    const start = { ...own, ...held.fields };
    const found = kept.of(next, start);
    const going = goingOn(store.get(), next, start);
    replaceScene(next, { ...start, ...going, ...found.lists });
    found.begin();
    held.begin();
    stage.look('front');
    link.begin(store.get(), embedded || going.clip ? '' : found.view);
    history.clear();
    // Of one path there is nothing to set but how it is compared.
    if (next.models.length > 1 && next.models.every(({ sliders }) => sliders.length < 2)) {
      tabs.select('Compare');
      tabs.open(!embedded && innerWidth > 720);
    }
  };
  const join = (next: Scene, added: readonly number[], came: readonly Clip[]) => {
    if (next === scene) return store.update(opened(store.get(), next, came));
    const first = store.get().shown.find((model) => !added.includes(model)) ?? 0;
    const shown = [first, ...added].slice(0, 3);
    const arrangement = store.get().arrangement === 'swipe' ? 'swipe' : 'side';
    const against = next.models.findIndex(({ role }) => role === 'truth');
    const start = { shown, arrangement, against: against >= 0 ? against : first } as const;
    replaceScene(next, { ...start, ...(next.models.length < 2 ? { arrangement: 'single' } : {}) });
    if (came.length > 0) store.update(opened(store.get(), next, came));
  };

  root.dataset.empty = 'true';
  tabs.open(!(embedded && innerWidth < 700));
  followTheme(store, (dark) => {
    stage.setDark(dark);
    draw();
  });
  store.subscribe(draw);
  askBeforeLeaving(store.get, keeper.holds);
  for (const happening of ['pointermove', 'wheel', 'keydown', 'pointerleave'] as const) {
    picture.addEventListener(happening, () => measure(), { passive: true });
  }
  for (const part of parts) part.load?.(null);
  draw();

  return {
    store,
    stage,
    scene: () => scene,
    show,
    look,
    tell: messages.tell,
    busy: messages.busy,
  };
}

function isGlb({ name }: File): boolean {
  return /\.gl(b|tf)$/i.test(name);
}

function block(...parts: Pick<Part, 'element'>[]): HTMLElement {
  return element('div', {}, ...parts.map((part) => part.element));
}

/** At most one call in so many milliseconds, and the last one never left out. */
function spaced(run: () => void, milliseconds: number): () => void {
  let timer: ReturnType<typeof setTimeout> | null = null;
  let last = -Infinity;
  return () => {
    timer ??= setTimeout(
      () => {
        timer = null;
        last = performance.now();
        run();
      },
      Math.max(0, last + milliseconds - performance.now()),
    );
  };
}
