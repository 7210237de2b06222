// The picture with everything over it, and a magnifier where the pointer is.
import { element } from '../../shared/element';
import type { Pixel } from '../types/task';
import { drawCross, drawGuess, drawHover, drawLine, drawMark, type Shown } from './markers';
import type { Pane, Spot } from './pane';
import { listenTo, type Hand } from './pointer';

const LENS = 150; // CSS pixels
const REACH = 11; // of a mark, for the pointer that drags it
const MEANT = 5; // and for a click, while another point is to be placed

/** What is drawn over the picture, in its own CSS pixels. */
export interface Over {
  readonly marks: readonly (Shown & { readonly name: string })[];
  readonly guess: { readonly spot: Spot; readonly label: string } | null;
  readonly lines: readonly { readonly points: readonly Pixel[]; readonly label: string }[];
  /** Whether a click would place a point, and whether that is missing here. */
  readonly places: boolean;
  readonly missing: boolean;
}

export class PictureStage {
  readonly element: HTMLElement;
  private readonly overlay = element('canvas', { class: 'over', 'aria-hidden': 'true' });
  private readonly lens = element('canvas', { class: 'lens', 'aria-hidden': 'true', hidden: true });
  private pane: Pane | null = null;
  private pointer: readonly [number, number] | null = null;
  private hovered: Spot | null = null;
  private over: Over = { marks: [], guess: null, lines: [], places: false, missing: false };
  private asked = false;

  /**
   * @param hand what is done with the pointer
   * @param above says what lies over the picture, whenever it is drawn
   */
  constructor(
    hand: Omit<Hand, 'hover' | 'markAt'>,
    private readonly above: () => Over,
  ) {
    this.element = element(
      'div',
      { class: 'picture', tabindex: 0, role: 'application', 'aria-label': 'The picture' },
      this.overlay,
      this.lens,
    );
    listenTo(this.element, {
      ...hand,
      markAt: (x, y) => this.nearest(x, y),
      click: (x, y, mark) => {
        const meant = this.over.missing ? this.nearest(x, y, MEANT) : mark;
        hand.click(x, y, meant);
      },
      hover: (at) => this.hover(at),
    });
    new ResizeObserver(() => this.shape()).observe(this.element);
    this.element.addEventListener('focus', () => this.request());
    this.element.addEventListener('blur', () => this.request());
  }

  show(pane: Pane | null, label: string): void {
    this.pane?.canvas.remove();
    this.pane = pane;
    this.hovered = null;
    this.element.setAttribute('aria-label', label);
    if (pane) this.element.prepend(pane.canvas);
    this.shape();
  }

  /** The middle of the picture, where keys place points. */
  get middle(): readonly [number, number] {
    return [this.element.clientWidth / 2, this.element.clientHeight / 2];
  }

  /** Draws at the next frame. */
  request(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.draw();
    });
  }

  private hover(at: readonly [number, number] | null): void {
    this.pointer = at;
    const found = at && this.pane?.hovers && this.over.places ? this.pane.pick(...at) : null;
    this.hovered = found && this.pane!.spot(found);
    this.element.dataset['over'] = at && this.nearest(...at) !== null ? 'mark' : 'picture';
    this.request();
  }

  private nearest(x: number, y: number, reach = REACH): string | null {
    let [best, least] = [null as string | null, reach];
    for (const { spot, name, active } of this.over.marks) {
      // Of two that lie together the active one is meant.
      const away = Math.hypot(spot.x - x, spot.y - y) - (active ? 2 : 0);
      if (away < least && !spot.hidden) [best, least] = [name, away];
    }
    return best;
  }

  private shape(): void {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (!width || !height) return;
    const ratio = devicePixelRatio;
    this.overlay.width = Math.round(width * ratio);
    this.overlay.height = Math.round(height * ratio);
    this.lens.width = this.lens.height = Math.round(LENS * ratio);
    this.pane?.resize(width, height, ratio);
    this.draw();
  }

  private draw(): void {
    const context = this.overlay.getContext('2d')!;
    const ratio = devicePixelRatio;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, this.element.clientWidth, this.element.clientHeight);
    this.over = this.above();
    this.magnify();
    this.pane?.draw();
    if (!this.pane) return;
    const { marks, guess, lines, places } = this.over;
    for (const { points, label } of lines) drawLine(context, points, label);
    if (guess) drawGuess(context, guess.spot, guess.label);
    for (const mark of marks) if (!mark.active) drawMark(context, mark);
    for (const mark of marks) if (mark.active) drawMark(context, mark);
    if (this.hovered && places) drawHover(context, this.hovered);
    if (places && this.element.matches(':focus-visible'))
      drawCross(context, ...this.middle, 14, 4);
  }

  private magnify(): void {
    const { pane, pointer, lens } = this;
    const shown = Boolean(pane && !pane.near && pointer && this.over.places);
    lens.hidden = !shown;
    if (!shown) return;
    const [x, y] = pointer!;
    const context = lens.getContext('2d')!;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, lens.width, lens.height);
    pane!.magnify(context, x, y, LENS);
    context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    drawCross(context, LENS / 2, LENS / 2, 22, 3);
    // Beside the pointer, and never outside of the picture.
    const aside = (at: number, room: number) => (at + 28 + LENS < room ? at + 28 : at - 28 - LENS);
    const left = aside(x, this.element.clientWidth);
    const top = Math.min(Math.max(y - LENS / 2, 6), this.element.clientHeight - LENS - 6);
    lens.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
  }
}
