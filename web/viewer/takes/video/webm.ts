// Writes WebM: pictures and sound that the browser has encoded, in clusters that begin with a whole
// picture, and a list of these for players that jump. After RFC 8794 (EBML) and RFC 9559 (Matroska).

export interface Track {
  readonly codec: 'V_VP9' | 'V_VP8' | 'A_OPUS';
  readonly size?: readonly [number, number];
  readonly sampleRate?: number;
  readonly channels?: number;
  /** What the decoder of a sound begins with. */
  readonly head?: Uint8Array<ArrayBuffer>;
}

/** Encoded data of one track at one time. */
export interface Block {
  readonly track: number; // from 1
  readonly milliseconds: number;
  readonly key: boolean;
  readonly content: Uint8Array<ArrayBuffer>;
}

type Bytes = Uint8Array<ArrayBuffer>;

const VIDEO = 1;
const AUDIO = 2;
const NAME = 'elastomorph';
const PREROLL = 80_000_000; // nanoseconds that a decoder of Opus needs before a jump
const SAMPLES = 48_000; // of Opus, a second

/** A file of so many milliseconds; its first track is the video. */
export function webm(tracks: readonly Track[], blocks: readonly Block[], duration: number): Blob {
  const info = master(
    0x1549a966,
    ...[whole(0x2ad7b1, 1_000_000), real(0x4489, duration), text(0x4d80, NAME), text(0x5741, NAME)],
  );
  const entries = master(0x1654ae6b, ...tracks.map((track, i) => entry(track, i + 1)));
  const ordered = [...blocks].sort((a, b) => a.milliseconds - b.milliseconds || a.track - b.track);
  const groups: Block[][] = [];
  for (const block of ordered) {
    if (groups.length === 0 || (block.track === 1 && block.key)) groups.push([]);
    groups.at(-1)!.push(block);
  }
  let place = info.length + entries.length;
  const cues: Bytes[] = [];
  const clusters = groups.map((group) => {
    const time = group[0]!.milliseconds;
    const made = master(
      0x1f43b675,
      whole(0xe7, time),
      ...group.map((block) => simple(block, time)),
    );
    const where = master(0xb7, whole(0xf7, 1), whole(0xf1, place));
    cues.push(master(0xbb, whole(0xb3, time), where));
    place += made.length;
    return made;
  });
  const header = master(
    0x1a45dfa3,
    ...[whole(0x4286, 1), whole(0x42f7, 1), whole(0x42f2, 4), whole(0x42f3, 8)],
    ...[text(0x4282, 'webm'), whole(0x4287, 4), whole(0x4285, 2)],
  );
  const segment = [info, entries, ...clusters, master(0x1c53bb6b, ...cues)];
  const size = segment.reduce((sum, part) => sum + part.length, 0);
  return new Blob([header, id(0x18538067), length(size), ...segment], { type: 'video/webm' });
}

function entry({ codec, size, sampleRate = 0, channels = 0, head }: Track, number: number): Bytes {
  const common = [whole(0xd7, number), whole(0x73c5, number), text(0x86, codec)];
  if (size)
    return master(
      0xae,
      ...[...common, whole(0x83, VIDEO)],
      master(0xe0, whole(0xb0, size[0]), whole(0xba, size[1])),
    );
  // Of the head of Opus, bytes 10 and 11 are the samples that come before the first one to be heard.
  const skipped = head ? head[10]! + 256 * head[11]! : 0;
  return master(
    0xae,
    ...[...common, whole(0x83, AUDIO)],
    ...(head ? [element(0x63a2, head), whole(0x56aa, (skipped / SAMPLES) * 1e9)] : []),
    whole(0x56bb, PREROLL),
    master(0xe1, real(0xb5, sampleRate), whole(0x9f, channels)),
  );
}

function simple({ track, milliseconds, key, content }: Block, from: number): Bytes {
  const head = new DataView(new ArrayBuffer(4));
  head.setUint8(0, 0x80 | track);
  head.setInt16(1, milliseconds - from);
  head.setUint8(3, key ? 0x80 : 0);
  return element(0xa3, joined(new Uint8Array(head.buffer), content));
}

function master(number: number, ...parts: readonly Bytes[]): Bytes {
  return element(number, joined(...parts));
}

function element(number: number, content: Bytes): Bytes {
  return joined(id(number), length(content.length), content);
}

function whole(number: number, value: number): Bytes {
  const bytes = new DataView(new ArrayBuffer(8));
  bytes.setBigUint64(0, BigInt(Math.round(value)));
  return element(number, new Uint8Array(bytes.buffer));
}

function real(number: number, value: number): Bytes {
  const bytes = new DataView(new ArrayBuffer(8));
  bytes.setFloat64(0, value);
  return element(number, new Uint8Array(bytes.buffer));
}

function text(number: number, value: string): Bytes {
  return element(number, new TextEncoder().encode(value));
}

/** The bytes of a number that marks its own length. */
function id(number: number): Bytes {
  const digits = number.toString(16);
  return Uint8Array.from({ length: digits.length / 2 }, (_, i) =>
    parseInt(digits.slice(2 * i, 2 * i + 2), 16),
  );
}

function length(bytes: number): Bytes {
  const eight = new DataView(new ArrayBuffer(8));
  eight.setBigUint64(0, (1n << 56n) | BigInt(bytes));
  return new Uint8Array(eight.buffer);
}

function joined(...parts: readonly Bytes[]): Bytes {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let place = 0;
  for (const part of parts) {
    all.set(part, place);
    place += part.length;
  }
  return all;
}
