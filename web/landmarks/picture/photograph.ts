// A photograph: a reduced picture of it while all is seen, its own pixels nearer by.
import type { Mark } from '../types/task';
import { rounded, type Pane, type Spot } from './pane';

const REDUCED = 1600; // pixels of the longer side
const MOST = 40; // CSS pixels for one of the photograph
const MARGIN = 0.97;
const COUNTED = 6; // CSS pixels from which those of the photograph can be counted

/** What is decoded of a photograph, upright; closed when another one is shown. */
export interface Decoded {
  readonly full: ImageBitmap;
  readonly reduced: ImageBitmap;
}

/** Decodes a photograph, turned upright as its EXIF data says. */
export async function decoded(file: Blob): Promise<Decoded> {
  const full = await createImageBitmap(file, { imageOrientation: 'from-image' });
  const share = Math.min(1, REDUCED / Math.max(full.width, full.height));
  const reduced = await createImageBitmap(full, {
    resizeWidth: Math.max(1, Math.round(share * full.width)),
    resizeHeight: Math.max(1, Math.round(share * full.height)),
    resizeQuality: 'high',
  });
  return { full, reduced };
}

/** Where a photograph is in the picture: a screen pixel is `scale` (pixel + ½) + (x, y). */
export interface PhotographView {
  scale: number;
  x: number;
  y: number;
}

export class PhotographPane implements Pane {
  readonly canvas = document.createElement('canvas');
  readonly hovers = false;
  private readonly context = this.canvas.getContext('2d')!;
  private shown: Decoded | null = null;
  private view: PhotographView | null = null;
  private fits = false; // nobody has moved it
  private width = 1;
  private height = 1;
  private ratio = 1;

  get near(): boolean {
    return (this.view?.scale ?? 0) >= COUNTED;
  }

  /** Shows a photograph from where it was looked at before, if it was. */
  show(photograph: Decoded | null, view: PhotographView | null): void {
    this.shown = photograph;
    this.view = view;
    this.fits = !view;
    if (photograph && !view) this.fit();
  }

  get looked(): PhotographView | null {
    return this.view && !this.fits ? { ...this.view } : null;
  }

  resize(width: number, height: number, ratio: number): void {
    const middle = this.view && this.pixel(this.width / 2, this.height / 2);
    Object.assign(this, { width, height, ratio });
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    if (this.fits) {
      this.fit();
    } else if (this.view && middle) {
      this.view.x = width / 2 - this.view.scale * (middle[0] + 0.5);
      this.view.y = height / 2 - this.view.scale * (middle[1] + 0.5);
      this.hold();
    }
  }

  fit(): void {
    if (!this.shown) return;
    const { width, height } = this.shown.full;
    this.fits = true;
    const scale = MARGIN * Math.min(this.width / width, this.height / height);
    this.view = {
      scale,
      x: (this.width - scale * width) / 2,
      y: (this.height - scale * height) / 2,
    };
  }

  actual(): void {
    if (this.view) this.zoom(1 / this.view.scale, this.width / 2, this.height / 2);
  }

  zoom(factor: number, x: number, y: number): void {
    if (!this.view || !this.shown) return;
    const { width, height } = this.shown.full;
    this.fits = false;
    const least = 0.5 * Math.min(this.width / width, this.height / height);
    const scale = Math.min(Math.max(this.view.scale * factor, least), MOST);
    const share = scale / this.view.scale;
    this.view = { scale, x: x - share * (x - this.view.x), y: y - share * (y - this.view.y) };
    this.hold();
  }

  grab(): void {}

  release(): void {}

  drag(dx: number, dy: number): void {
    if (!this.view) return;
    this.fits = false;
    this.view = { ...this.view, x: this.view.x + dx, y: this.view.y + dy };
    this.hold();
  }

  spot({ at: [x = 0, y = 0] }: Mark): Spot | null {
    if (!this.view) return null;
    const { scale } = this.view;
    return { x: this.view.x + scale * (x + 0.5), y: this.view.y + scale * (y + 0.5), hidden: false };
  }

  pick(x: number, y: number): Mark | null {
    return this.inside(this.pixel(x, y));
  }

  nudged({ at: [x = 0, y = 0] }: Mark, dx: number, dy: number): Mark | null {
    return this.inside([x + dx, y + dy]);
  }

  draw(): void {
    const { context, view, shown } = this;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (view && shown) this.paint(context, shown, view, this.width, this.height);
  }

  magnify(context: CanvasRenderingContext2D, x: number, y: number, size: number): void {
    if (!this.view || !this.shown) return;
    const scale = Math.min(Math.max(4 * this.view.scale, 2), 4 * MOST);
    const share = scale / this.view.scale;
    const half = size / 2;
    const view = { scale, x: half - share * (x - this.view.x), y: half - share * (y - this.view.y) };
    this.paint(context, this.shown, view, size, size);
  }

  /** Draws what of the photograph is in a picture so wide and high. */
  private paint(
    context: CanvasRenderingContext2D,
    { full, reduced }: Decoded,
    { scale, x, y }: PhotographView,
    width: number,
    height: number,
  ): void {
    const { ratio } = this;
    const source = scale * ratio <= reduced.width / full.width ? reduced : full;
    const share = full.width / source.width;
    const tall = full.height / source.height;
    // The part that is seen, and a pixel around it.
    const [x0, y0] = [-x / scale / share - 1, -y / scale / tall - 1];
    const [x1, y1] = [(width - x) / scale / share + 1, (height - y) / scale / tall + 1];
    const [a, b] = [Math.max(0, Math.floor(x0)), Math.max(0, Math.floor(y0))];
    const [c, d] = [Math.min(source.width, Math.ceil(x1)), Math.min(source.height, Math.ceil(y1))];
    if (c <= a || d <= b) return;
    // Pixels that can be counted are shown as such.
    context.imageSmoothingEnabled = scale < COUNTED;
    context.imageSmoothingQuality = 'high';
    const s = scale * ratio;
    context.drawImage(
      source, a, b, c - a, d - b,
      x * ratio + s * share * a, y * ratio + s * tall * b, s * share * (c - a), s * tall * (d - b),
    );
  }

  private pixel(x: number, y: number): [number, number] {
    const { scale, x: left, y: top } = this.view ?? { scale: 1, x: 0, y: 0 };
    return [(x - left) / scale - 0.5, (y - top) / scale - 0.5];
  }

  private inside([x, y]: readonly [number, number]): Mark | null {
    if (!this.shown) return null;
    const { width, height } = this.shown.full;
    const within = x >= -0.5 && y >= -0.5 && x <= width - 0.5 && y <= height - 0.5;
    return within ? { at: [rounded(x), rounded(y)] } : null;
  }

  /** Keeps some of the photograph in the picture. */
  private hold(): void {
    if (!this.view || !this.shown) return;
    const [width, height] = [this.shown.full.width, this.shown.full.height];
    const { scale } = this.view;
    const held = (at: number, length: number, room: number) =>
      Math.min(Math.max(at, room / 2 - length), room / 2);
    this.view.x = held(this.view.x, scale * width, this.width);
    this.view.y = held(this.view.y, scale * height, this.height);
  }
}
