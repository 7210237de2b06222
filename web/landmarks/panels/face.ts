// A drawing of a face with the points on it, as one looks at the subject.
import { element } from '../../shared/element';

const SVG = 'http://www.w3.org/2000/svg';

/** Where points are in the drawing, 200 wide and 236 high; right is the subject's left. */
const PLACES: Readonly<Record<string, readonly [number, number]>> = {
  nose_tip: [100, 139],
  right_eye_outer: [45, 96],
  right_eye_inner: [81, 99],
  left_eye_inner: [119, 99],
  left_eye_outer: [155, 96],
  nose_bridge: [100, 93],
  right_nostril: [82, 149],
  left_nostril: [118, 149],
  mouth_right: [70, 180],
  mouth_left: [130, 180],
  upper_lip: [100, 171],
  lower_lip: [100, 192],
  chin: [100, 222],
  right_jaw: [38, 178],
  left_jaw: [162, 178],
};

// Half of it; the other half is its mirror image.
const HALF = [
  'M100 8C58 8 30 38 29 84C29 122 31 152 38 178C50 204 78 222 100 222', // outline
  'M29 96C20 90 17 102 21 116C24 130 29 138 33 134', // ear
  'M40 78C52 68 72 68 86 76', // brow
  'M45 96C54 85 72 86 81 99C70 105 54 105 45 96', // lids
  'M63 88A7.5 7.5 0 1 0 63 103A7.5 7.5 0 1 0 63 88', // iris
  'M93 88C94 108 90 124 83 138C78 146 81 152 88 151C92 152 96 154 100 154', // nose
  'M70 180C82 174 92 169 100 171M70 180C80 178 92 180 100 180M70 180C80 190 90 192 100 192', // lips
];

export interface FaceDrawing {
  readonly element: HTMLElement;
  /** Which point is asked for, and how far each has come: 0, 1 or in between. */
  show(active: string | null, done: (name: string) => number): void;
}

export function createFace(names: readonly string[], choose: (name: string) => void): FaceDrawing {
  const drawing = document.createElementNS(SVG, 'svg');
  drawing.setAttribute('viewBox', '0 0 200 236');
  drawing.setAttribute('aria-hidden', 'true');
  const lines = HALF.map((d) => `<path d="${d}"/>`).join('');
  drawing.innerHTML = `<g class="lines">${lines}<g transform="matrix(-1 0 0 1 200 0)">${lines}</g></g>`;
  const dots = new Map<string, SVGCircleElement>();
  for (const name of names) {
    const place = PLACES[name];
    if (!place) continue;
    const dot = document.createElementNS(SVG, 'circle');
    dot.setAttribute('cx', String(place[0]));
    dot.setAttribute('cy', String(place[1]));
    dot.addEventListener('click', () => choose(name));
    drawing.append(dot);
    dots.set(name, dot);
  }
  return {
    element: element(
      'div',
      { class: 'drawing' },
      element('span', { class: 'side' }, 'subject’s right'),
      drawing,
      element('span', { class: 'side' }, 'subject’s left'),
    ),
    show(active, done) {
      for (const [name, dot] of dots) {
        const share = done(name);
        dot.setAttribute('class', share >= 1 ? 'done' : share > 0 ? 'begun' : '');
        dot.setAttribute('r', name === active ? '7' : '4.5');
        dot.toggleAttribute('data-active', name === active);
      }
    },
  };
}
