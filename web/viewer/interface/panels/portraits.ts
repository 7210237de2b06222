// Pictures of the poses in sight, drawn one after another while nothing else moves.
import type { Context } from '../parts/part';
import type { PoseRow } from './pose_row';

const PAUSE = 40; // milliseconds between two, so that the page stays alive
const MANY = 400; // pictures that are kept: more than there is room for at once

export interface Portraits {
  /** The rows that want a picture, in their order. */
  show(rows: readonly PoseRow[]): void;
  /** Another face is there. */
  forget(): void;
}

export function createPortraits({ store, stage, scene }: Context): Portraits {
  const drawn = new Map<string, HTMLCanvasElement>();
  let given = new WeakMap<PoseRow, HTMLCanvasElement>();
  let wanted: readonly PoseRow[] = [];
  const inSight = new Set<Element>();
  const sight = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries)
      if (isIntersecting) inSight.add(target);
      else inSight.delete(target);
    again();
  });
  let timer: ReturnType<typeof setTimeout> | undefined;

  // Another theme and another face beside it look different.
  const keyOf = ({ pose }: PoseRow) =>
    JSON.stringify([
      pose.weights,
      document.documentElement.dataset.theme,
      store.get().shown[0] ?? 0,
    ]);
  const next = () => {
    timer = undefined;
    if (!scene()) return;
    const row = wanted.find(
      (one) =>
        inSight.has(one.element) &&
        (given.get(one) !== drawn.get(keyOf(one)) || !given.has(one)),
    );
    if (!row) return;
    const key = keyOf(row);
    if (!drawn.has(key)) {
      if (store.get().playing) {
        again();
        return;
      }
      drawn.set(key, stage.portrait(row.pose.weights));
      if (drawn.size > MANY) drawn.delete(drawn.keys().next().value!);
    }
    const picture = drawn.get(key)!;
    given.set(row, picture);
    row.picture(picture);
    again();
  };
  const again = () => {
    timer ??= setTimeout(next, PAUSE);
  };

  return {
    show(rows) {
      if (rows !== wanted) {
        sight.disconnect();
        inSight.clear();
        for (const { element } of rows) sight.observe(element);
        wanted = rows;
      }
      if (inSight.size > 0) again();
    },
    forget() {
      drawn.clear();
      given = new WeakMap();
    },
  };
}
