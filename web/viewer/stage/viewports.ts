// Which models are drawn where on the canvas.
import type { ViewState } from '../types/state';

/** In CSS pixels from the lower left; `cut` is the part of the area that is drawn. */
export interface Viewport {
  readonly model: number;
  readonly area: Area;
  readonly cut: Area;
}

export interface Area {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

/** Whether an area holds a place in CSS pixels from the lower left. */
export function within({ x, y, width, height }: Area, right: number, up: number): boolean {
  return right >= x && right < x + width && up >= y && up < y + height;
}

/** Such a place as the area counts it, −1 to 1 rightwards and upwards. */
export function inArea({ x, y, width, height }: Area, right: number, up: number): [number, number] {
  return [(2 * (right - x)) / width - 1, (2 * (up - y)) / height - 1];
}

type Arranged = Pick<ViewState, 'arrangement' | 'shown' | 'swipe'>;

/** The viewports of a canvas, left to right; models that do not exist are passed over. */
export function viewportsOf(
  state: Arranged,
  models: number,
  width: number,
  height: number,
): Viewport[] {
  const known = state.shown.filter(
    (model) => Number.isInteger(model) && model >= 0 && model < models,
  );
  const shown = known.length > 0 ? known : models > 0 ? [0] : [];
  const whole: Area = { x: 0, y: 0, width, height };
  const [first, second] = shown;
  if (first === undefined) return [];
  if (state.arrangement === 'side' && shown.length > 1) {
    return shown.map((model, i) => {
      const [start, end] = [i, i + 1].map((n) => Math.round((n * width) / shown.length)) as [
        number,
        number,
      ];
      const area = { x: start, y: 0, width: end - start, height };
      return { model, area, cut: area };
    });
  }
  if (state.arrangement === 'swipe' && second !== undefined) {
    const split = Math.round(Math.min(Math.max(state.swipe, 0), 1) * width);
    return [
      { model: first, area: whole, cut: { ...whole, width: split } },
      { model: second, area: whole, cut: { ...whole, x: split, width: width - split } },
    ].filter(({ cut }) => cut.width > 0);
  }
  return [{ model: first, area: whole, cut: whole }];
}
