// Taking hold of the timeline: the clock, the in and out point, curves and their keys.
import type { Clip } from '../../types/model';
import { RULER } from './drawing';
import { moving, nearestFrame, type Plot, secondsAt, valueAt, xOf, yOf } from './sight';

export interface Deeds {
  clip(): Clip | null;
  plot(): Plot;
  range(): readonly [number, number];
  chosen(): string;
  choose(slider: string): void;
  scrub(seconds: number): void;
  setRange(range: readonly [number, number]): void;
  setKey(clip: Clip, frame: number, value: number): void;
  zoom(factor: number, about: number): void;
  pan(seconds: number): void;
  step(frames: number): void;
  raise(by: number): void;
}

type Drag = (x: number, y: number) => void;

const [NEAR, NEAR_FINGER] = [9, 22]; // CSS pixels
const ZOOM = 1.0015; // a pixel of the wheel

export function grips(strip: HTMLElement, deeds: Deeds): void {
  let drag: Drag | null = null;
  const at = (event: MouseEvent) => {
    const { left, top } = strip.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top] as const;
  };
  strip.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    drag = taken(deeds, ...at(event), event.pointerType === 'touch' ? NEAR_FINGER : NEAR);
    if (drag) strip.setPointerCapture(event.pointerId);
  });
  strip.addEventListener('pointermove', (event) => drag?.(...at(event)));
  for (const end of ['pointerup', 'pointercancel'] as const)
    strip.addEventListener(end, () => (drag = null));
  strip.addEventListener(
    'wheel',
    (event) => {
      const { clip, plot, pan, zoom } = deeds;
      if (!clip()) return;
      event.preventDefault();
      const sideways = event.shiftKey ? event.deltaY || event.deltaX : event.deltaX;
      const { sight, width } = plot();
      if (sideways !== 0) pan((sideways / width) * (sight[1] - sight[0]));
      else zoom(ZOOM ** -event.deltaY, secondsAt(plot(), at(event)[0]));
    },
    { passive: false },
  );
  strip.addEventListener('keydown', (event) => {
    const many = event.shiftKey ? 10 : 1;
    const run = {
      ArrowLeft: () => deeds.step(-many),
      ArrowRight: () => deeds.step(many),
      ArrowUp: () => deeds.raise(0.01 * many),
      ArrowDown: () => deeds.raise(-0.01 * many),
      Home: () => deeds.scrub(deeds.range()[0]),
      End: () => deeds.scrub(deeds.range()[1]),
    }[event.key];
    if (!run || !deeds.clip()) return;
    event.preventDefault();
    run();
  });
}

/** What a pointer takes hold of where it goes down. */
function taken(deeds: Deeds, x: number, y: number, near: number): Drag | null {
  const clip = deeds.clip();
  if (!clip) return null;
  const scrub: Drag = (to) => deeds.scrub(secondsAt(deeds.plot(), to));
  if (y < RULER) {
    const end = deeds
      .range()
      .findIndex((seconds) => Math.abs(xOf(deeds.plot(), seconds) - x) <= near);
    if (end >= 0)
      return (to) => {
        const moved = deeds.range().with(end, secondsAt(deeds.plot(), to)) as [number, number];
        if (moved[0] <= moved[1]) deeds.setRange(moved);
      };
  } else {
    const frame = nearestFrame(clip, secondsAt(deeds.plot(), x));
    const off = (slider: string) =>
      Math.abs(yOf(deeds.plot(), clip.tracks.get(slider)?.[frame] ?? NaN) - y);
    if (off(deeds.chosen()) <= near) return keyDrag(deeds, frame, y);
    const [nearest] = moving(clip).sort((a, b) => off(a) - off(b));
    if (nearest !== undefined && off(nearest) <= near) {
      deeds.choose(nearest);
      return null;
    }
  }
  scrub(x, y);
  return scrub;
}

function keyDrag(deeds: Deeds, frame: number, from: number): Drag {
  const [clip, plot] = [deeds.clip()!, deeds.plot()]; // what is dragged stays under the pointer
  const value = clip.tracks.get(deeds.chosen())![frame]!;
  const grabbed = valueAt(plot, from);
  return (_, y) => deeds.setKey(clip, frame, value + valueAt(plot, y) - grabbed);
}
