// How the face is drawn, and what the drawing costs.
import type { Readout } from '../../types/stage';
import { choice, toggle } from '../parts/controls';
import { element, setText } from '../../../shared/element';
import type { Context, Part } from '../parts/part';

export interface Display extends Part {
  readout(found: Readout): void;
}

export function createDisplay({ store, scene }: Context): Display {
  const shading = choice(store, 'shading', 'Shading', [
    ['smooth', 'Smooth'],
    ['flat', 'Flat'],
  ]);
  const light = choice(store, 'light', 'Light', [
    ['studio', 'Studio'],
    ['matcap', 'Matcap'],
  ]);
  const theme = choice(store, 'theme', 'Theme', [
    ['system', 'System'],
    ['light', 'Light'],
    ['dark', 'Dark'],
  ]);
  const wireframe = toggle(store, 'wireframe', 'Wireframe', 'W');
  const loops = toggle(store, 'loops', 'Edge loops');
  const head = toggle(store, 'headTurns', 'Head turns as recorded');

  const figures = new Map<string, HTMLElement>();
  const table = element('dl', { class: 'figures' });
  for (const name of ['Face', 'Frame', 'Targets active', 'On the card', 'Posed by']) {
    const figure = element('dd', {}, '–');
    figures.set(name, figure);
    table.append(element('div', {}, element('dt', {}, name), figure));
  }
  const write = (name: string, text: string) => {
    const figure = figures.get(name);
    if (figure) setText(figure, text);
  };

  return {
    element: element(
      'div',
      {},
      element(
        'section',
        { class: 'block' },
        element('h2', {}, 'Surface'),
        shading.element,
        light.element,
        wireframe.element,
        loops.element,
        head.element,
      ),
      element('section', { class: 'block' }, element('h2', {}, 'Page'), theme.element),
      element('section', { class: 'block' }, element('h2', {}, 'Figures'), table),
    ),
    show(state) {
      const shown = state.shown.map((model) => scene()?.models[model]);
      for (const part of [shading, light, theme, wireframe, loops, head]) part.show(state);
      loops.refuse(
        shown.some((model) => (model?.loops.length ?? 0) > 0)
          ? null
          : 'Nobody traced edge loops for this model.',
      );
      const face = shown[0];
      if (!face) return;
      const vertices = (face.neutral.length / 3).toLocaleString('en');
      const triangles = (face.triangles.length / 3).toLocaleString('en');
      write('Face', `${vertices} vertices, ${triangles} triangles`);
    },
    readout(found) {
      write('Frame', frameWords(found));
      write('Targets active', String(found.targets));
      write('On the card', `${found.mebibytes.toFixed(1)} MiB`);
      write('Posed by', found.gpu ? 'graphics card' : 'processor (no float render targets)');
    },
  };
}

export function frameWords(found: Readout): string {
  const cost = `${found.frameMilliseconds.toFixed(1)} ms`;
  const rate = found.framesPerSecond;
  return rate === null ? cost : `${cost}, ${Math.round(rate)} fps`;
}
