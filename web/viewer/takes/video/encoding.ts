// Pictures and sound through the browser's own encoders (WebCodecs), into blocks of a file.
import type { Block, Track } from './webm';

const KINDS = [
  ['vp09.00.40.08', 'V_VP9'],
  ['vp8', 'V_VP8'],
] as const;
const BITS = 8; // a pixel and second
const SOUND_BITS = 128_000; // a second
const WAITING = 4; // pictures in the encoder's queue
const BETWEEN_KEYS = 2; // seconds
const PART = 4800; // samples handed over at a time

export interface PictureEncoder {
  readonly track: Track;
  readonly blocks: readonly Block[];
  /** Encodes what a canvas shows now; kept when there is room for the next. */
  add(canvas: HTMLCanvasElement, frame: number): Promise<void>;
  finish(): Promise<void>;
  close(): void;
}

/** An encoder of pictures of this size, or null where the browser has none. */
export async function pictureEncoder(
  size: readonly [number, number],
  fps: number,
): Promise<PictureEncoder | null> {
  if (!('VideoEncoder' in globalThis)) return null;
  const [width, height] = size;
  for (const [codec, name] of KINDS) {
    const bitrate = BITS * width * height;
    const config = {
      codec,
      width,
      height,
      bitrate,
      framerate: fps,
      latencyMode: 'quality',
    } as const;
    const { supported } = await VideoEncoder.isConfigSupported(config);
    if (supported) return encoderOf(config, { codec: name, size }, fps);
  }
  return null;
}

function encoderOf(config: VideoEncoderConfig, track: Track, fps: number): PictureEncoder {
  const blocks: Block[] = [];
  let failed: Error | null = null;
  const encoder = new VideoEncoder({
    output: (chunk) => blocks.push(blockOf(chunk, 1)),
    error: (problem) => (failed = problem),
  });
  encoder.configure(config);
  const { width, height } = config;
  return {
    track,
    blocks,
    async add(canvas, frame) {
      const picture = new VideoFrame(canvas, {
        timestamp: Math.round((frame / fps) * 1e6),
        visibleRect: { x: 0, y: 0, width, height },
      });
      encoder.encode(picture, { keyFrame: frame % Math.ceil(BETWEEN_KEYS * fps) === 0 });
      picture.close();
      do await new Promise((next) => setTimeout(next));
      while (!failed && encoder.encodeQueueSize > WAITING);
      if (failed) throw new Error(`The browser could not encode the video: ${failed.message}`);
    },
    finish: () => encoder.flush(),
    close: () => encoder.state !== 'closed' && encoder.close(),
  };
}

/** A sound, encoded as Opus; null where the browser cannot. */
export async function encodedSound(
  buffer: AudioBuffer,
): Promise<{ track: Track; blocks: Block[] } | null> {
  if (!('AudioEncoder' in globalThis)) return null;
  const { numberOfChannels, sampleRate } = buffer;
  const config = { codec: 'opus', numberOfChannels, sampleRate, bitrate: SOUND_BITS };
  if (!(await AudioEncoder.isConfigSupported(config)).supported) return null;
  const blocks: Block[] = [];
  let head: Uint8Array<ArrayBuffer> | undefined;
  const encoder = new AudioEncoder({
    output: (chunk, described) => {
      const found = described?.decoderConfig?.description;
      if (found)
        head = new Uint8Array(
          found instanceof ArrayBuffer ? found : (found as Uint8Array<ArrayBuffer>),
        );
      blocks.push(blockOf(chunk, 2));
    },
    error: () => undefined, // flush says it too
  });
  encoder.configure(config);
  for (let start = 0; start < buffer.length; start += PART) {
    const frames = Math.min(PART, buffer.length - start);
    const planes = new Float32Array(frames * numberOfChannels);
    for (let channel = 0; channel < numberOfChannels; channel += 1)
      planes.set(buffer.getChannelData(channel).subarray(start, start + frames), channel * frames);
    const timestamp = Math.round((start / sampleRate) * 1e6);
    const format = 'f32-planar';
    const part = {
      format,
      sampleRate,
      numberOfFrames: frames,
      numberOfChannels,
      timestamp,
    } as const;
    const data = new AudioData({ ...part, data: planes });
    encoder.encode(data);
    data.close();
  }
  await encoder.flush();
  encoder.close();
  const track: Track = { codec: 'A_OPUS', sampleRate, channels: numberOfChannels };
  return { track: head ? { ...track, head } : track, blocks };
}

function blockOf(chunk: EncodedVideoChunk | EncodedAudioChunk, track: number): Block {
  const content = new Uint8Array(chunk.byteLength);
  chunk.copyTo(content);
  const milliseconds = Math.max(0, Math.round(chunk.timestamp / 1000));
  return { track, milliseconds, key: chunk.type === 'key', content };
}
