// The keys of the viewer.
import { besideFrame, clipNamed } from '../../rig/clips';
import type { View } from '../../types/stage';
import type { ViewState } from '../../types/state';
import type { Context } from '../parts/part';
import type { GrabTool } from '../../grab/tool';
import type { History } from '../state/history';
import type { Player } from '../state/player';
import { atRest } from '../state/posing';
import type { Key } from '../../../shared/keys';

export const VIEWS: readonly (readonly [View, string])[] = [
  ['front', 'Front'],
  ['three-quarter', '¾'],
  ['side', 'Side'],
  ['below', 'Below'],
];

const T_STEP = 0.05;
const TURN = Math.PI / 36;
const NEARER = 1.1;

export interface Deeds {
  readonly grab: GrabTool;
  readonly history: History;
  look(view: View): void;
  search(): void;
  swap(): void;
  draw(): void;
  star(): void;
  savePose(): void;
  mark(end: 'in' | 'out'): void;
  timeline(): void;
  link(): void;
  help(): void;
  close(): void;
}

export function keymap({ store, stage, scene }: Context, player: Player, deeds: Deeds): Key[] {
  const flip = (field: 'ghost' | 'wireframe' | 'orbits' | 'mirror' | 'heat') => () =>
    store.update({ [field]: !store.get()[field] });
  const step = (direction: number) => {
    const state: ViewState = store.get();
    const clip = clipNamed(scene()?.models ?? [], state);
    if (!clip) store.update({ t: state.t + direction * T_STEP, playing: false });
    else store.update({ clipTime: besideFrame(clip, state.clipTime, direction), playing: false });
  };
  const turns: Record<string, [number, number]> = {
    ArrowLeft: [-TURN, 0],
    ArrowRight: [TURN, 0],
    ArrowUp: [0, TURN],
    ArrowDown: [0, -TURN],
  };
  return [
    { keys: [' '], caps: ['Space'], words: 'Play or pause', run: () => player.toggle() },
    {
      keys: ['[', ']'],
      caps: ['[', ']'],
      words: 'Step t back or on; a frame of a performance',
      run: (key) => step(key === '[' ? -1 : 1),
    },
    {
      keys: ['{', '}'],
      caps: ['{', '}'],
      words: 'In and out point of a performance',
      run: (key) => deeds.mark(key === '{' ? 'in' : 'out'),
    },
    { keys: ['t'], caps: ['T'], words: 'Timeline of a performance', run: deeds.timeline },
    {
      keys: ['0'],
      caps: ['0'],
      words: 'All sliders to zero',
      run: () => store.update(atRest(store.get())),
    },
    {
      keys: ['z'],
      caps: ['Ctrl', 'Z'],
      words: 'Undo; with Shift redo',
      ctrl: true,
      run: (_, shift) => (shift ? deeds.history.redo() : deeds.history.undo()),
    },
    {
      keys: ['y'],
      caps: ['Ctrl', 'Y'],
      words: 'Redo',
      ctrl: true,
      run: () => deeds.history.redo(),
    },
    {
      keys: ['m'],
      caps: ['M'],
      words: 'Mirror: move left and right together',
      run: flip('mirror'),
    },
    { keys: ['x'], caps: ['X'], words: 'Swap left and right of the pose', run: deeds.swap },
    { keys: ['r'], caps: ['R'], words: 'Random pose of the sliders shown', run: deeds.draw },
    {
      keys: ['s'],
      caps: ['S'],
      words: 'Favourite: the slider that has the focus',
      run: deeds.star,
    },
    { keys: ['p'], caps: ['P'], words: 'Save the pose under a name', run: deeds.savePose },
    { keys: ['l'], caps: ['L'], words: 'Copy a link to this view', run: deeds.link },
    { keys: ['/'], caps: ['/'], words: 'Search sliders', run: deeds.search },
    {
      keys: ['1', '2', '3', '4'],
      caps: ['1', '2', '3', '4'],
      words: 'Look from the front, three-quarter, the side, below',
      run: (key) => {
        const view = VIEWS[Number(key) - 1];
        if (view) deeds.look(view[0]);
      },
    },
    {
      keys: Object.keys(turns),
      caps: ['←', '→', '↑', '↓'],
      words: 'Turn the camera, while the picture has the focus, or move the grabbed vertex',
      inPicture: true,
      run: (key, shift) => {
        const [right, up] = turns[key] ?? [0, 0];
        if (!deeds.grab.nudge(Math.sign(right), Math.sign(up), shift)) stage.turn(right, up);
      },
    },
    {
      keys: ['+', '=', '-'],
      caps: ['+', '−'],
      words: 'Nearer, farther',
      run: (key) => stage.zoom(key === '-' ? 1 / NEARER : NEARER),
    },
    { keys: ['d'], caps: ['D'], words: 'Grab the face and drag it', run: deeds.grab.toggle },
    { keys: ['g'], caps: ['G'], words: 'Ghost of the neutral', run: flip('ghost') },
    {
      keys: ['h'],
      caps: ['H'],
      words: 'Heat map of distances',
      run: () => {
        if ((scene()?.models.length ?? 0) > 1) flip('heat')();
      },
    },
    { keys: ['o'], caps: ['O'], words: 'Orbits of picked vertices', run: flip('orbits') },
    { keys: ['w'], caps: ['W'], words: 'Wireframe', run: flip('wireframe') },
    {
      keys: ['f'],
      caps: ['F'],
      words: 'Flat or smooth shading',
      run: () => store.update({ shading: store.get().shading === 'flat' ? 'smooth' : 'flat' }),
    },
    { keys: ['Escape'], caps: ['Esc'], words: 'Close what is open', run: deeds.close },
    { keys: ['?'], caps: ['?'], words: 'This list', run: deeds.help },
  ];
}
