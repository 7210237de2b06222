// Texts that hold bytes, compressed with zlib and written in base64: long lists of whole numbers as
// elastomorph packs them into the JSON part of a file, and what the page itself rarely needs.
import { bytesOfBase64 } from '../../shared/base64';

/**
 * The `count` whole numbers in a text, or null where it is no such text or holds others: 32-bit
 * integers, each less the one before it.
 */
export async function unpacked(text: unknown, count: number): Promise<Int32Array | null> {
  if (typeof text !== 'string') return null;
  const bytes = await inflated(text, 4 * count).catch(() => null);
  if (bytes?.length !== 4 * count) return null;
  const numbers = new Int32Array(bytes.buffer);
  for (let i = 1; i < numbers.length; i += 1) numbers[i]! += numbers[i - 1]!;
  return numbers;
}

/**
 * The bytes of a compressed text.
 *
 * @throws Error where they are more than `most`, of which no more are unpacked, or damaged
 */
export async function inflated(text: string, most = 2 ** 24): Promise<Uint8Array<ArrayBuffer>> {
  const stream = new Blob([await bytesOfBase64(text)]).stream();
  const reader = stream.pipeThrough(new DecompressionStream('deflate')).getReader();
  const parts: Uint8Array<ArrayBuffer>[] = [];
  for (let length = 0; ;) {
    const { done, value } = await reader.read();
    if (done) return joined(parts, length);
    length += value.length;
    if (length > most) {
      await reader.cancel();
      throw new Error(`more than ${most} bytes`);
    }
    parts.push(value);
  }
}

function joined(parts: readonly Uint8Array[], length: number): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(length);
  let start = 0;
  for (const part of parts) {
    bytes.set(part, start);
    start += part.length;
  }
  return bytes;
}
