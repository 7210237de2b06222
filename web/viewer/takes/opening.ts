// Takes and sounds people open or drop: a take plays on the rig that is shown, a sound beside a take.
import { wordsOf } from '../../shared/start';
import type { Opener } from '../interface/page/opening';
import type { Context } from '../interface/parts/part';
import { clipNamed, span } from '../rig/clips';
import { freshName } from '../interface/poses/list';
import type { Clip, Scene } from '../types/model';
import type { ViewState } from '../types/state';
import { inFile, isSame } from './carrying';
import { carried, nameOf, readTake, TAKES } from './reading';
import { SOUNDS, type Speaker } from './sound';

const ALIKE = 0.1; // seconds that a sound and its take may differ in length
const POSES = /^\W{0,4}pose\W/i; // how a table of poses begins

/** Takes with one more, or with another in place of that of its name. */
export function withTake(takes: readonly Clip[], take: Clip): readonly Clip[] {
  const place = takes.findIndex(({ name }) => name === take.name);
  return place < 0 ? [...takes, take] : takes.with(place, take);
}

/** What changes where performances have come with a face: all are there as takes, the first to play. */
export function opened(
  { takes, shown }: ViewState,
  { models }: Scene,
  came: readonly Clip[],
): Partial<ViewState> {
  const sliders = models[shown[0] ?? 0]?.sliders ?? [];
  let all = takes;
  let first: Clip | null = null;
  for (const one of came) {
    const others = [...all, ...models.flatMap(({ clips }) => clips)].filter((clip) => clip !== one);
    const same = others.find((clip) => isSame(clip, one));
    const name = same?.name ?? freshName(others, one.name);
    const fitted = carried(one, sliders);
    const take = same ?? { ...(fitted.tracks.size > 0 ? fitted : one), name };
    inFile(take);
    if (!same) all = [...all, take];
    first ??= take;
  }
  return first ? { takes: all, ...chosen(first) } : {};
}

/** A take from its beginning. */
function chosen(take: Clip): Partial<ViewState> {
  return { clip: take.name, clipTime: span(take)[0], range: null, playing: false };
}

export interface Takes extends Opener {
  /** Also files of faces, for the performances in them. */
  readonly acceptsHere: string;
}

/** @param poses opens a table of poses, which has the suffix of a take */
export function takesOpener(
  { store, scene, tell, say }: Context,
  speaker: Speaker,
  poses?: (file: File) => Promise<void>,
): Takes {
  const openTake = async (file: File) => {
    if (poses && /\.csv$/i.test(file.name) && POSES.test(await file.slice(0, 64).text()))
      return poses(file);
    const model = scene()?.models[store.get().shown[0] ?? 0];
    if (!model)
      throw new Error(
        `${file.name} holds weights of sliders: open a rig (.glb) first, then the take.`,
      );
    const take = await readTake(file, model.sliders);
    inFile(take);
    if (take.recorded?.guessed) tell(`${file.name}: ${take.recorded.guessed}.`);
    store.update({
      takes: withTake(store.get().takes, take),
      ...chosen(take),
      // Sound has no way back.
      ...(store.get().repeat === 'back and forth' && { repeat: 'loop' }),
    });
  };
  const openSound = async (file: File) => {
    const { takes, clip: chosen } = store.get();
    // Phones call what belongs together alike.
    const own = takes.find(({ name }) => name === nameOf(file.name));
    const clip = own ?? clipNamed(scene()?.models ?? [], { takes, clip: chosen });
    if (!clip)
      throw new Error(`${file.name} is a sound: open or choose its take first, to play beside it.`);
    const buffer = await speaker.read(file);
    const [first, last] = span(clip);
    const sound = speaker.lend(clip.name, first, file, buffer);
    store.update({ soundOffsets: { ...store.get().soundOffsets, [clip.name]: 0 } });
    if (Math.abs(sound.seconds - (last - first)) > ALIKE)
      say(
        `${file.name} is ${sound.seconds.toFixed(2)} s long and ${clip.name} ` +
          `${(last - first).toFixed(2)} s: both begin together, and the sound ends with the take at the latest.`,
      );
  };
  return {
    accepts: '.csv,.npz,.wav,.mp3,.ogg,.flac,.m4a,.mp4,.m4v,.mov,.webm',
    acceptsHere: '.csv,.npz,.glb,.gltf,.vrm',
    fits: (files) => files.filter(({ name }) => TAKES.test(name) || SOUNDS.test(name)),
    async open(files) {
      const sounds = files.filter(({ name }) => SOUNDS.test(name));
      const takes = files.filter((file) => !sounds.includes(file));
      for (const [some, open] of [
        [takes, openTake],
        [sounds, openSound],
      ] as const)
        for (const file of some)
          await open(file).catch((problem: unknown) => tell(wordsOf(problem)));
    },
  };
}
