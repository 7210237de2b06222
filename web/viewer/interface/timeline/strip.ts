// The picture of a take: its curves under a ruler, with the sound between them, to be taken hold of.
import { element } from '../../../shared/element';
import { clipNamed, played, span } from '../../rig/clips';
import { edited, moveKey } from '../../takes/editing';
import { withTake } from '../../takes/opening';
import { offsetOf, type Speaker } from '../../takes/sound';
import type { Clip } from '../../types/model';
import type { ViewState } from '../../types/state';
import type { Context } from '../parts/part';
import * as drawing from './drawing';
import { grips } from './grips';
import { moving, nearestFrame, placed, type Plot, reached, type Sight, zoomed } from './sight';

export interface Strip {
  readonly element: HTMLElement;
  show(state: ViewState): void;
  /** Name of the curve that is edited; empty for all of them. */
  choose(slider: string): void;
  chosen(): string;
  reach(frames: number): void;
  /** How near it looks, 0 for the whole take to 1. */
  near(share: number): void;
}

const NEAREST = 200; // times

/** @param changed hears that another curve was chosen, or another part is in sight */
export function createStrip(
  context: Context,
  speaker: Speaker,
  changed: (near: number) => void,
): Strip {
  const { store, scene } = context;
  const still = element('canvas', { 'aria-hidden': 'true' });
  const front = element('canvas', { 'aria-hidden': 'true' });
  const whole = element(
    'div',
    {
      class: 'strip',
      tabindex: 0,
      role: 'application',
      'aria-roledescription': 'curves of a take',
    },
    still,
    front,
  );
  let chosen = '';
  let reach = 0;
  let sight: Sight = [0, 1];
  let sighted: Float64Array | null = null; // times of the take that is in sight
  let drawn: readonly unknown[] = [];

  const clip = () => clipNamed(scene()?.models ?? [], store.get());
  const frame = (of: Clip) => (span(of)[1] - span(of)[0]) / Math.max(1, of.times.length - 1);

  const plotOf = (of: Clip): Plot => ({
    width: Math.max(1, whole.clientWidth),
    height: Math.max(1, whole.clientHeight),
    top: drawing.RULER + (speaker.of(of.name) ? drawing.WAVE : 0),
    sight,
    values: reached(of),
  });

  const look = (next: Sight) => {
    sight = next;
    const of = clip();
    if (of)
      changed(Math.log((span(of)[1] - span(of)[0]) / (next[1] - next[0])) / Math.log(NEAREST));
    show(store.get());
  };

  const setKey = (of: Clip, at: number, value: number) =>
    store.update({
      takes: withTake(store.get().takes, edited(of, [chosen], moveKey(at, value, reach))),
    });

  const show = (state: ViewState) => {
    const of = clip();
    if (!of || whole.clientWidth === 0) return;
    if (of.times !== sighted) {
      sighted = of.times;
      sight = span(of);
      changed(0);
    }
    if (chosen && !of.tracks.has(chosen)) chosen = '';
    const { clipTime, playing } = state;
    if (playing && (clipTime < sight[0] || clipTime > sight[1])) {
      sight = placed(clipTime, sight[1] - sight[0], span(of));
    }
    const plot = plotOf(of);
    const colours = coloursOf(whole);
    const others = moving(of).filter((name) => name !== chosen);
    const sound = speaker.of(of.name);
    const now = [
      ...[plot.width, plot.height, ...sight, ...plot.values, offsetOf(state), sound],
      ...[devicePixelRatio, colours.text, ...others.map((name) => of.tracks.get(name))],
    ];
    if (now.length !== drawn.length || now.some((one, i) => one !== drawn[i])) {
      drawn = now;
      const pen = penFor(still, plot);
      drawing.drawStill(pen, plot, of, others, colours);
      if (sound) drawing.drawSound(pen, plot, sound, sound.begin + offsetOf(state), colours);
    }
    const pen = penFor(front, plot);
    const track = of.tracks.get(chosen);
    if (track) drawing.drawChosen(pen, plot, of, track, colours);
    drawing.drawRange(pen, plot, played(of, state.range), colours);
    drawing.drawNow(pen, plot, clipTime, colours);
    const value = track ? `, ${track[nearestFrame(of, clipTime)]!.toFixed(2)} now` : '';
    whole.setAttribute(
      'aria-label',
      `${chosen || 'All curves'}${value}. Left and right step frames, up and down move the key`,
    );
  };

  grips(whole, {
    clip,
    plot: () => plotOf(clip()!),
    range: () => played(clip()!, store.get().range),
    chosen: () => chosen,
    choose: (slider) => choose(slider),
    scrub: (seconds) => store.update({ clipTime: seconds, playing: false }),
    setRange: (range) => store.update({ range }),
    setKey,
    zoom: (factor, about) => {
      const of = clip();
      if (of) look(zoomed(sight, factor, about, span(of), frame(of)));
    },
    pan: (seconds) => {
      const of = clip();
      if (of) look(placed(sight[0] + seconds, sight[1] - sight[0], span(of)));
    },
    step: (frames) => {
      const of = clip();
      if (!of) return;
      const at = Math.min(
        of.times.length - 1,
        Math.max(0, nearestFrame(of, store.get().clipTime) + frames),
      );
      store.update({ clipTime: of.times[at]!, playing: false });
    },
    raise: (by) => {
      const of = clip();
      const track = of?.tracks.get(chosen);
      if (!of || !track) return;
      const at = nearestFrame(of, store.get().clipTime);
      setKey(of, at, track[at]! + by);
    },
  });
  new ResizeObserver(() => show(store.get())).observe(whole);

  const choose = (slider: string) => {
    chosen = slider;
    look(sight);
  };
  return {
    element: whole,
    show,
    choose,
    chosen: () => chosen,
    reach: (frames) => (reach = frames),
    near(share) {
      const of = clip();
      if (!of) return;
      const all = span(of)[1] - span(of)[0];
      const now = store.get().clipTime;
      const about = now >= sight[0] && now <= sight[1] ? now : (sight[0] + sight[1]) / 2;
      look(
        zoomed(sight, (sight[1] - sight[0]) / (all / NEAREST ** share), about, span(of), frame(of)),
      );
    },
  };
}

/** What draws on an empty canvas. */
function penFor(canvas: HTMLCanvasElement, { width, height }: Plot): drawing.Pen {
  const ratio = devicePixelRatio;
  const size = [Math.round(width * ratio), Math.round(height * ratio)] as const;
  const pen = canvas.getContext('2d')!;
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = '11px system-ui, sans-serif';
  return pen;
}

function coloursOf(of: HTMLElement): drawing.Colours {
  const style = getComputedStyle(of);
  const colour = (name: string) => style.getPropertyValue(`--${name}`).trim();
  return {
    accent: colour('accent'),
    ground: colour('ground'),
    line: colour('line'),
    muted: colour('muted'),
    text: colour('text'),
  };
}
