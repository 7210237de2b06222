// The images of a file as pixels: their sizes are read first, so that none is unpacked in vain.
import { listed, type GltfDocument } from './document';

const MOST_PIXELS = 8192 ** 2; // of an image that is shown
const LARGEST = 4096; // pixels on a side of what is kept of it
const ROOM = 2 ** 26; // pixels of all images together

/** Images by their numbers. What cannot be shown is null, and named in the notes. */
export class Images {
  private readonly found = new Map<number, Promise<ImageBitmap | null>>();
  private readonly problems = new Map<string, number[]>();
  private readonly largest: number;

  /** `wanted` are the numbers that will be asked for. */
  constructor(
    private readonly file: GltfDocument,
    wanted: Iterable<number>,
  ) {
    const sizes = [...new Set(wanted)].map((number) => sizeOf(this.bytes(number) ?? NOTHING));
    const pixels = (side: number) =>
      sizes.reduce((sum, size) => sum + (size ? area(shrunk(size, side)) : 0), 0);
    let side = LARGEST;
    while (side > 256 && pixels(side) > ROOM) side /= 2;
    this.largest = side;
  }

  of(number: number): Promise<ImageBitmap | null> {
    if (!this.found.has(number)) this.found.set(number, this.decoded(number));
    return this.found.get(number)!;
  }

  /** A sentence for each reason why images are not shown. */
  get notes(): string[] {
    return [...this.problems].map(([problem, numbers]) => {
      const many = numbers.length > 1;
      const some = numbers.slice(0, 4).join(', ') + (numbers.length > 4 ? ', …' : '');
      const subject = many ? `images ${some} are` : `image ${some} is`;
      return `${this.file.name}: ${subject} ${problem}; only colours are shown there.`;
    });
  }

  private async decoded(number: number): Promise<ImageBitmap | null> {
    if (number < 0) return null; // its texture names none
    const bytes = this.bytes(number);
    if (!bytes) return this.without(number, 'not in the file');
    if (bytes[0] === 0xab && bytes[1] === 0x4b)
      return this.without(number, 'KTX 2, which this page does not read: export PNG, JPEG or WebP');
    const size = sizeOf(bytes);
    if (!size) return this.without(number, UNKNOWN);
    if (area(size) > MOST_PIXELS) return this.without(number, 'larger than 8,192 × 8,192 pixels');
    const settings = { colorSpaceConversion: 'none', premultiplyAlpha: 'none' } as const;
    const [resizeWidth, resizeHeight] = shrunk(size, this.largest);
    const resized = resizeWidth < size[0] ? { resizeWidth, resizeHeight } : {};
    try {
      return await createImageBitmap(new Blob([bytes]), { ...settings, ...resized });
    } catch {
      return this.without(number, UNKNOWN);
    }
  }

  private bytes(number: number): Uint8Array<ArrayBuffer> | null {
    const view = listed(this.file, 'bufferViews', listed(this.file, 'images', number)['bufferView']);
    const buffer = this.file.buffers[Number(view['buffer'] ?? -1)];
    const [start, length] = [Number(view['byteOffset'] ?? 0), Number(view['byteLength'])];
    if (!buffer || !(start >= 0 && start + length <= buffer.length)) return null;
    return buffer.subarray(start, start + length) as Uint8Array<ArrayBuffer>;
  }

  private without(number: number, problem: string): null {
    const others = this.problems.get(problem) ?? [];
    this.problems.set(problem, [...others, number]);
    return null;
  }
}

type Size = readonly [width: number, height: number];

const NOTHING = new Uint8Array(0);
const UNKNOWN = 'damaged, or of a kind that this browser does not know';

function area([width, height]: Size): number {
  return width * height;
}

function shrunk([width, height]: Size, most: number): Size {
  const share = Math.min(1, most / Math.max(width, height));
  return [Math.max(1, Math.round(width * share)), Math.max(1, Math.round(height * share))];
}

/** What an image says of its size: PNG, JPEG, WebP or AVIF; null where it says nothing. */
function sizeOf(bytes: Uint8Array): Size | null {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const start = String.fromCharCode(...bytes.subarray(0, 64));
  try {
    if (start.startsWith('PNG', 1)) return [view.getUint32(16), view.getUint32(20)];
    if (start.startsWith('\xff\xd8')) return sizeOfJpeg(view);
    if (/^RIFF....WEBP/s.test(start)) return sizeOfWebp(view, start.slice(12, 16));
    if (/^....ftypavi/s.test(start)) return sizeOfAvif(view);
  } catch {
    // It ends before it says so.
  }
  return null;
}

/** In the first segment that starts a frame: C0 to CF but for C4, C8 and CC, which hold tables. */
function sizeOfJpeg(view: DataView): Size {
  for (let place = 2; ; place += 2 + view.getUint16(place + 2)) {
    const mark = view.getUint8(place + 1);
    if (mark === 0xc0 || (mark > 0xc0 && mark <= 0xcf && mark % 4 !== 0))
      return [view.getUint16(place + 7), view.getUint16(place + 5)];
  }
}

function sizeOfWebp(view: DataView, kind: string): Size {
  const three = (at: number) => view.getUint16(at, true) + (view.getUint8(at + 2) << 16);
  if (kind === 'VP8X') return [1 + three(24), 1 + three(27)];
  if (kind === 'VP8L') {
    const bits = view.getUint32(21, true);
    return [1 + (bits & 0x3fff), 1 + ((bits >> 14) & 0x3fff)];
  }
  return [view.getUint16(26, true) & 0x3fff, view.getUint16(28, true) & 0x3fff];
}

/** In its property "ispe": the largest, where it has thumbnails too. */
function sizeOfAvif(view: DataView): Size | null {
  let found: Size | null = null;
  for (let at = 0; at + 16 <= Math.min(view.byteLength, 4096); at += 1) {
    if (view.getUint32(at) !== 0x69737065) continue;
    const size = [view.getUint32(at + 8), view.getUint32(at + 12)] as const;
    if (!found || area(size) > area(found)) found = size;
  }
  return found;
}
