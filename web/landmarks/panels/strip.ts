// All photographs and surfaces in a row, small, with how many points each has.
import { element, setAttribute, setText } from '../../shared/element';
import type { Place } from '../types/task';

const HEIGHT = 62; // CSS pixels

export interface Strip {
  readonly element: HTMLElement;
  /** Takes over a small picture of a place. */
  picture(number: number, small: ImageBitmap | HTMLCanvasElement): void;
  has(number: number): boolean;
  show(current: number, counts: readonly number[]): void;
}

export function createStrip(
  places: readonly Place[],
  points: number,
  choose: (number: number) => void,
): Strip {
  const shown = new Set<number>();
  const tiles = places.map((place, number) => {
    const canvas = element('canvas', { height: 1, width: 1, 'aria-hidden': 'true' });
    canvas.hidden = place.kind !== 'photograph';
    const count = element('span', { class: 'badge' });
    const title = place.pose ? `${place.pose}/${place.name}` : place.name;
    const tile = element(
      'button',
      { type: 'button', class: `tile ${place.kind}`, title },
      canvas,
      element('span', { class: 'caption' }, place.kind === 'photograph' ? place.name : `${place.name} (3D)`),
      count,
    );
    tile.addEventListener('click', () => choose(number));
    return { tile, canvas, count };
  });
  return {
    element: element(
      'nav',
      { class: 'strip', 'aria-label': 'Photographs and surfaces', hidden: places.length < 2 },
      ...tiles.map(({ tile }) => tile),
    ),
    has: (number) => shown.has(number),
    picture(number, small) {
      const { canvas } = tiles[number]!;
      const height = HEIGHT * Math.min(2, devicePixelRatio);
      canvas.hidden = false;
      canvas.height = height;
      canvas.width = Math.max(1, Math.round((height * small.width) / small.height));
      const context = canvas.getContext('2d')!;
      context.imageSmoothingQuality = 'high';
      context.drawImage(small, 0, 0, canvas.width, canvas.height);
      shown.add(number);
    },
    show(current, counts) {
      tiles.forEach(({ tile, count }, number) => {
        const here = number === current;
        if (here && tile.getAttribute('aria-current') === null)
          tile.scrollIntoView({ block: 'nearest', inline: 'nearest' });
        setAttribute(tile, 'aria-current', here && 'true');
        const own = counts[number]!;
        setText(count, own ? `${own}/${points}` : '');
        tile.dataset['full'] = String(own === points);
      });
    },
  };
}
