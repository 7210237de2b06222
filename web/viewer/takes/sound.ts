// Sound beside takes: while it plays, its clock leads and the picture follows.
import { numberOf } from '../../shared/named';
import { grouped, refuse } from '../files/container';
import type { ViewState } from '../types/state';

export const SOUNDS = /\.(wav|mp3|mp4|m4v|m4a|mov|webm|ogg|flac)$/i;
const LARGEST = 2 ** 30; // bytes of a file
const LONGEST = 7200; // seconds: two hours are 2.6 GiB in memory
const PEAKS = 200; // loudest moments kept, a second
const RATE = 48_000; // samples a second of a video's sound
const SOON = 0.01; // seconds until a sound that was asked for begins
const SAME = 1e-6; // seconds: a moment that went through the state is still the one told

export interface Sound {
  readonly name: string;
  readonly file: File;
  readonly seconds: number;
  readonly begin: number; // second of its take at which it sounds, where it is not set off
  /** (PEAKS a second) how loud it is, 0 to 1. */
  readonly peaks: Float32Array;
}

type Lent = Sound & { readonly buffer: AudioBuffer };
type Moment = Pick<ViewState, 'clip' | 'clipTime' | 'speed' | 'soundOffsets'>;

export interface Speaker {
  /** Reads a sound, or the sound of a video. @throws Error with a sentence for people */
  read(file: File): Promise<AudioBuffer>;
  /** Gives a take, which begins at a second, its sound. */
  lend(take: string, begin: number, file: File, buffer: AudioBuffer): Sound;
  of(take: string | null): Sound | null;
  /** Calls back when a take has got another sound. */
  subscribe(listener: () => void): void;
  /**
   * Sounds from this moment on, or goes on sounding: the second of the take that is heard now; null
   * where nothing can sound. It ends with a second of the take, also where nobody follows any more.
   */
  follow(moment: Moment, end: number): number | null;
  hush(): void;
  /** What of a take's sound is heard in so many seconds from a moment on; null where it has none. */
  render(moment: Moment, seconds: number): Promise<AudioBuffer | null>;
}

/** Seconds that the sound of the present take begins after it. */
export function offsetOf({ clip, soundOffsets }: Pick<ViewState, 'clip' | 'soundOffsets'>): number {
  return numberOf(soundOffsets, clip ?? '');
}

export function createSpeaker(): Speaker {
  const sounds = new Map<string, Lent>(); // by take
  const listeners: (() => void)[] = [];
  let context: AudioContext | null = null;
  let source: AudioBufferSourceNode | null = null;
  let begun = { at: 0, from: 0, speed: 1, as: '' };
  let told = 0;

  const own = () => (context ??= new AudioContext({ latencyHint: 'interactive' }));

  const hush = () => {
    source?.disconnect();
    source = null;
  };

  const begin = (sounding: AudioContext, of: Lent, moment: Moment, end: number, as: string) => {
    hush();
    const at = sounding.currentTime + SOON;
    source = started(sounding, of, moment, at);
    source.stop(at + Math.max(0, end - moment.clipTime) / moment.speed);
    begun = { at, from: moment.clipTime, speed: moment.speed, as };
  };

  /** The moment of the context's clock that comes out of the loudspeaker now. */
  const clock = (sounding: AudioContext) =>
    sounding.currentTime - (sounding.outputLatency || sounding.baseLatency || 0);

  return {
    async read(file) {
      const { name, size } = file;
      if (size > LARGEST)
        refuse(
          name,
          `it has ${grouped(Math.ceil(size / 2 ** 20))} MiB; sounds of up to 1,024 MiB are ` +
            'opened here. Save the sound alone as a WAV.',
        );
      const buffer = await file
        .arrayBuffer()
        .then((bytes) => own().decodeAudioData(bytes))
        .catch(() =>
          refuse(
            name,
            'this browser finds no sound in it that it can read. Save the sound as a WAV.',
          ),
        );
      if (buffer.duration > LONGEST)
        refuse(
          name,
          `it is ${grouped(Math.round(buffer.duration / 60))} minutes long; sounds of up to ` +
            'two hours are opened here. Cut it.',
        );
      return buffer;
    },
    lend(take, begin, file, buffer) {
      const [{ name }, seconds, peaks] = [file, buffer.duration, peaksOf(buffer)];
      const sound = { name, file, begin, seconds, peaks, buffer };
      sounds.set(take, sound);
      hush();
      for (const listener of listeners) listener();
      return sound;
    },
    subscribe: (listener) => void listeners.push(listener),
    of: (take) => (take === null ? null : (sounds.get(take) ?? null)),
    follow(moment, end) {
      const { clip, clipTime, speed } = moment;
      const sound = sounds.get(clip ?? '');
      if (!sound || !context) return null;
      if (context.state !== 'running') {
        hush();
        void context.resume().catch(() => undefined); // it waits for people to touch the page
        return null;
      }
      const as = `${clip} ${speed} ${offsetOf(moment)} ${end}`;
      if (!source || as !== begun.as || Math.abs(clipTime - told) > SAME)
        begin(context, sound, moment, end, as);
      told = begun.from + begun.speed * Math.max(0, clock(context) - begun.at);
      return told;
    },
    hush,
    async render(moment, seconds) {
      const sound = sounds.get(moment.clip ?? '');
      if (!sound) return null;
      const channels = Math.min(2, sound.buffer.numberOfChannels);
      const offline = new OfflineAudioContext(channels, Math.ceil(seconds * RATE), RATE);
      started(offline, sound, moment, 0);
      return offline.startRendering();
    },
  };
}

/** A sound as it is heard with its take, which is at a moment when the clock of a context is at `at`. */
function started(
  context: BaseAudioContext,
  { buffer, begin }: Lent,
  moment: Moment,
  at: number,
): AudioBufferSourceNode {
  const { clipTime, speed } = moment;
  const into = clipTime - begin - offsetOf(moment);
  const source = context.createBufferSource();
  source.buffer = buffer;
  source.playbackRate.value = speed;
  source.connect(context.destination);
  source.start(at + Math.max(0, -into) / speed, Math.min(buffer.duration, Math.max(0, into)));
  return source;
}

function peaksOf(buffer: AudioBuffer): Float32Array {
  const step = buffer.sampleRate / PEAKS;
  const peaks = new Float32Array(Math.ceil(buffer.length / step));
  for (let channel = 0; channel < buffer.numberOfChannels; channel += 1) {
    const samples = buffer.getChannelData(channel);
    for (let i = 0; i < samples.length; i += 1) {
      const place = Math.floor(i / step);
      const loud = Math.abs(samples[i]!);
      if (loud > peaks[place]!) peaks[place] = loud;
    }
  }
  return peaks;
}

/** How loud a sound is at most between two of its seconds. */
export function loudness({ peaks }: Sound, from: number, to: number): number {
  let most = 0;
  const last = Math.min(peaks.length, Math.ceil(to * PEAKS));
  for (let i = Math.max(0, Math.floor(from * PEAKS)); i < last; i += 1)
    most = Math.max(most, peaks[i]!);
  return most;
}
