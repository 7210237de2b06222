// Mouse, pen and fingers on the picture: click, drag a mark, drag the picture, wheel, pinch.

export interface Hand {
  /** The name of the mark under a point of the picture, if there is one. */
  markAt(x: number, y: number): string | null;
  /** A click, also on a mark. */
  click(x: number, y: number, mark: string | null): void;
  /** A mark is about to be dragged. */
  take(name: string): void;
  moveMark(name: string, x: number, y: number): void;
  drop(): void;
  grab(x: number, y: number): void;
  drag(dx: number, dy: number, move: boolean): void;
  release(): void;
  zoom(factor: number, x: number, y: number): void;
  /** The pointer is here now; null where it left. */
  hover(at: readonly [number, number] | null): void;
}

const STILL = 4; // CSS pixels that a click may slip
const WHEEL = 0.0016;

export function listenTo(element: HTMLElement, hand: Hand): void {
  const fingers = new Map<number, [number, number]>();
  let start: [number, number] | null = null;
  let mark: string | null = null;
  let slipped = false;
  let moves = false;
  const place = (event: MouseEvent): [number, number] => {
    const box = element.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  element.addEventListener('pointerdown', (event) => {
    if (event.button === 1) event.preventDefault(); // no scrolling by the wheel's button
    const [x, y] = place(event);
    element.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [x, y]);
    slipped = slipped || fingers.size > 1; // two fingers never click
    if (fingers.size > 1) return;
    [start, slipped] = [[x, y], event.button !== 0];
    moves = event.button !== 0 || event.shiftKey;
    mark = event.button === 0 ? hand.markAt(x, y) : null;
    if (mark === null) hand.grab(x, y);
    hand.hover([x, y]);
  });
  element.addEventListener('pointermove', (event) => {
    const [x, y] = place(event);
    const before = fingers.get(event.pointerId);
    if (!before) {
      hand.hover([x, y]);
      return;
    }
    fingers.set(event.pointerId, [x, y]);
    if (fingers.size === 2) {
      const [other] = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      const apart = ([a, b]: [number, number]) => Math.hypot(a - other![0], b - other![1]) || 1;
      const middle: [number, number] = [(x + other![0]) / 2, (y + other![1]) / 2];
      hand.drag((x - before[0]) / 2, (y - before[1]) / 2, true);
      hand.zoom(apart([x, y]) / apart(before), ...middle);
      hand.hover(null);
      return;
    }
    if (start && !slipped && Math.hypot(x - start[0], y - start[1]) < STILL) return;
    // What was held back while it might have been a click is made up for.
    const [fromX, fromY] = slipped || !start ? before : start;
    if (mark !== null && !slipped) hand.take(mark);
    slipped = true;
    if (mark !== null) hand.moveMark(mark, x, y);
    else hand.drag(x - fromX, y - fromY, moves);
    hand.hover(mark !== null ? [x, y] : null);
  });
  const up = (event: PointerEvent) => {
    if (!fingers.delete(event.pointerId)) return;
    const [x, y] = place(event);
    if (fingers.size > 0) return;
    if (mark === null) hand.release();
    else if (slipped) hand.drop();
    if (event.type === 'pointerup' && !slipped && start) hand.click(x, y, mark);
    [start, mark, slipped] = [null, null, false];
    hand.hover(event.pointerType === 'mouse' ? [x, y] : null);
  };
  element.addEventListener('pointerup', up);
  element.addEventListener('pointercancel', up);
  element.addEventListener('pointerleave', () => hand.hover(null));
  element.addEventListener('contextmenu', (event) => event.preventDefault());
  element.addEventListener(
    'wheel',
    (event) => {
      event.preventDefault();
      const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 30 : 1;
      const step = Math.min(Math.max(event.deltaY * lines, -300), 300) * (event.ctrlKey ? 5 : 1);
      hand.zoom(Math.exp(-WHEEL * step), ...place(event));
    },
    { passive: false },
  );
}
