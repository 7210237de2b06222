// Videos of takes: each frame is posed, drawn and encoded in its turn, so that none is dropped and
// picture and sound belong together however slow the machine is.
import type { Context } from '../../interface/parts/part';
import { clipNamed, frameRate, played } from '../../rig/clips';
import type { Speaker } from '../sound';
import { encodedSound, pictureEncoder } from './encoding';
import { webm } from './webm';

const [SLOWEST, FASTEST] = [20, 60]; // frames a second
const PART_OF_FRAME = 0.05; // that cameras run fast

export interface VideoOptions {
  /** Pixels; null for those of the canvas as it is. */
  readonly size: readonly [number, number] | null;
  /** Of the wall behind the face; null as the page is. */
  readonly dark: boolean | null;
}

export interface Recorder {
  /**
   * The video of a take from its in to its out point at its speed; null where it was stopped.
   *
   * @param progress hears which share is done
   * @throws Error with a sentence for people
   */
  record(options: VideoOptions, progress: (share: number) => void): Promise<Blob | null>;
  recording(): boolean;
  stop(): void;
}

/** @param picture holds the canvas */
export function createRecorder(
  { store, stage, scene }: Context,
  speaker: Speaker,
  picture: HTMLElement,
  dark: () => boolean,
): Recorder {
  let busy = false;
  let stopped = false;

  const frames = async (fps: number, count: number, progress: (share: number) => void) => {
    const state = store.get();
    const [first] = played(clipNamed(scene()?.models ?? [], state)!, state.range);
    const canvas = picture.querySelector('canvas')!;
    // Pairs of pixels share a colour.
    const size = [Math.max(2, canvas.width & ~1), Math.max(2, canvas.height & ~1)] as const;
    const encoder = await pictureEncoder(size, fps);
    if (!encoder)
      throw new Error(
        'This browser encodes no video. Save the take as CSV, and make the video with "elastomorph ' +
          'render rig.glb --take take.csv -o take.mp4".',
      );
    try {
      for (let frame = 0; frame < count && !stopped; frame += 1) {
        stage.show({ ...state, clipTime: first + (frame * state.speed) / fps });
        stage.flush();
        await encoder.add(canvas, frame);
        progress((frame + 1) / count);
      }
      await encoder.finish();
      return encoder;
    } finally {
      encoder.close();
    }
  };

  const record = async (
    { size, dark: wall }: VideoOptions,
    progress: (share: number) => void,
  ): Promise<Blob | null> => {
    store.update({ playing: false });
    const state = store.get();
    const clip = clipNamed(scene()?.models ?? [], state);
    if (!clip) throw new Error('There is no take to record: open one first.');
    const [first, last] = played(clip, state.range);
    const fps = framesASecond(frameRate(clip));
    const count = Math.floor(((last - first) / state.speed) * fps + PART_OF_FRAME) + 1;
    const restore = fitted(picture, size);
    if (wall !== null) stage.setDark(wall);
    try {
      await twoFrames(); // the canvas has its new size
      const sound = await speaker.render({ ...state, clipTime: first }, count / fps);
      const heard = sound && (await encodedSound(sound));
      if (sound && !heard)
        throw new Error(
          'This browser encodes no sound. Record in a recent Chrome, Edge or Firefox.',
        );
      const { track, blocks } = await frames(fps, count, progress);
      if (stopped) return null;
      const tracks = heard ? [track, heard.track] : [track];
      return webm(tracks, [...blocks, ...(heard?.blocks ?? [])], (1000 * count) / fps);
    } finally {
      restore();
      stage.setDark(dark());
      stage.show(store.get());
    }
  };

  return {
    recording: () => busy,
    stop: () => (stopped = true),
    async record(options, progress) {
      [busy, stopped] = [true, false];
      try {
        return await record(options, progress);
      } finally {
        busy = false;
      }
    },
  };
}

/** Those of a take, or so many times as many as move: an animation may have a key a second. */
function framesASecond(rate: number): number {
  return Math.min(FASTEST, rate * Math.ceil(SLOWEST / rate));
}

/**
 * Gives the canvas so many pixels, or those that it has, whatever becomes of the window; it is shown
 * no larger than the picture. Returns how to take that back.
 */
function fitted(picture: HTMLElement, size: VideoOptions['size']): () => void {
  const before = picture.style.cssText;
  const ratio = Math.min(devicePixelRatio, 2); // as the stage draws
  const { clientWidth, clientHeight } = picture;
  const [width, height] = size?.map((pixels) => pixels / ratio) ?? [clientWidth, clientHeight];
  const scale = Math.min(1, clientWidth / width!, clientHeight / height!);
  const left = (clientWidth - scale * width!) / 2;
  const top = (clientHeight - scale * height!) / 2;
  picture.style.cssText =
    `position: absolute; inset: auto; width: ${width}px; height: ${height}px; ` +
    `left: ${left}px; top: ${top}px; transform-origin: 0 0; transform: scale(${scale})`;
  return () => (picture.style.cssText = before);
}

function twoFrames(): Promise<void> {
  return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done())));
}
