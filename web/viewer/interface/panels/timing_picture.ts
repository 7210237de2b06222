// The small drawing of a timing: t over the time of a run, with a dot where the clock stands.
import { timingLaw } from '../../rig/timing';
import type { TimingName } from '../../types/state';

const [WIDTH, HEIGHT, EDGE] = [44, 24, 3];

export interface TimingPicture {
  readonly element: SVGSVGElement;
  show(timing: TimingName, phase: number): void;
}

export function timingPicture(): TimingPicture {
  const drawing = svg('svg', { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, class: 'timing-picture' });
  drawing.setAttribute('aria-hidden', 'true');
  const curve = svg('path', { class: 'curve' });
  const dot = svg('circle', { r: '2.5', class: 'dot' });
  drawing.append(curve, dot);
  let drawn: TimingName | null = null;
  return {
    element: drawing,
    show(timing, phase) {
      const law = timingLaw(timing);
      if (timing !== drawn) {
        const points = Array.from({ length: 41 }, (_, i) => place(i / 40, law(i / 40)));
        curve.setAttribute('d', `M${points.map(([x, y]) => `${x} ${y}`).join('L')}`);
        drawn = timing;
      }
      const [x, y] = place(phase, law(phase));
      dot.setAttribute('cx', x);
      dot.setAttribute('cy', y);
    },
  };
}

function place(share: number, value: number): [string, string] {
  const x = EDGE + share * (WIDTH - 2 * EDGE);
  const y = HEIGHT - EDGE - value * (HEIGHT - 2 * EDGE);
  return [x.toFixed(1), y.toFixed(1)];
}

function svg<K extends keyof SVGElementTagNameMap>(tag: K, attributes: Record<string, string>) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
