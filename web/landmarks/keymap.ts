// The keys of the page.
import type { Key } from '../shared/keys';

export interface Deeds {
  turnPage(by: number): void;
  nextPoint(by: number): void;
  nextMissing(): void;
  place(): void;
  placeGuess(): void;
  remove(): void;
  undo(): void;
  redo(): void;
  save(): void;
  arrow(dx: number, dy: number): void;
  zoom(factor: number): void;
  fit(): void;
  actual(): void;
  clay(): void;
  edges(): void;
  help(): void;
}

const ARROWS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};
const NEARER = 1.25;

export function keymap(deeds: Deeds): Key[] {
  return [
    {
      keys: ['[', ']', 'PageUp', 'PageDown'],
      caps: ['[', ']'],
      words: 'The photograph before, the next one',
      run: (key) => deeds.turnPage(key === '[' || key === 'PageUp' ? -1 : 1),
    },
    {
      keys: [',', '.'],
      caps: [',', '.'],
      words: 'The point before, the next one',
      run: (key) => deeds.nextPoint(key === ',' ? -1 : 1),
    },
    { keys: ['Escape'], caps: ['Esc'], words: 'The next point that is missing here', run: () => deeds.nextMissing() },
    {
      keys: ['Enter'],
      caps: ['Enter'],
      words: 'Place the point in the middle of the picture',
      inPicture: true,
      run: () => deeds.place(),
    },
    { keys: ['g'], caps: ['G'], words: 'Place the point where other photographs put it', run: () => deeds.placeGuess() },
    {
      keys: Object.keys(ARROWS),
      caps: ['←', '→', '↑', '↓'],
      words: 'Move the point by a pixel; where it is missing, move the picture or turn the surface',
      inPicture: true,
      run: (key) => deeds.arrow(...(ARROWS[key] ?? [0, 0])),
    },
    {
      keys: ['Delete', 'Backspace'],
      caps: ['Del'],
      words: 'Remove the point from this picture',
      run: () => deeds.remove(),
    },
    {
      keys: ['z', 'y'],
      caps: ['Ctrl', 'Z'],
      words: 'Undo; with Shift, redo',
      ctrl: true,
      run: (key, shift) => (key === 'y' || shift ? deeds.redo() : deeds.undo()),
    },
    { keys: ['s'], caps: ['Ctrl', 'S'], words: 'Save now', ctrl: true, run: () => deeds.save() },
    {
      keys: ['+', '=', '-'],
      caps: ['+', '−'],
      words: 'Nearer, farther; also the wheel',
      run: (key) => deeds.zoom(key === '-' ? 1 / NEARER : NEARER),
    },
    { keys: ['0', 'f'], caps: ['0'], words: 'All of it', run: () => deeds.fit() },
    { keys: ['1'], caps: ['1'], words: 'Pixel for pixel; a surface from the front', run: () => deeds.actual() },
    { keys: ['t'], caps: ['T'], words: 'Texture or clay', run: () => deeds.clay() },
    { keys: ['w'], caps: ['W'], words: 'Edges of the mesh', run: () => deeds.edges() },
    { keys: ['?'], caps: ['?'], words: 'This list', run: () => deeds.help() },
  ];
}
