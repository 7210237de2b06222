// Long lists of whole numbers as elastomorph packs them into the JSON part of a file: differences
// of neighbours, as 32-bit integers, compressed with zlib and written in base64.
import { bytesOfBase64 } from '../../shared/base64';

/** The `count` whole numbers in a text, or null where it is no such text or holds others. */
export async function unpacked(text: unknown, count: number): Promise<Int32Array | null> {
  if (typeof text !== 'string') return null;
  const bytes = await inflated(text, 4 * count);
  if (!bytes) return null;
  const numbers = new Int32Array(bytes.buffer);
  for (let i = 1; i < numbers.length; i += 1) numbers[i]! += numbers[i - 1]!;
  return numbers;
}

/** The bytes of a compressed text; never more than `length` of them are unpacked. */
async function inflated(text: string, length: number): Promise<Uint8Array<ArrayBuffer> | null> {
  const found = new Uint8Array(length);
  try {
    const stream = new Blob([await bytesOfBase64(text)]).stream();
    const reader = stream.pipeThrough(new DecompressionStream('deflate')).getReader();
    for (let place = 0; ;) {
      const { done, value } = await reader.read();
      if (done) return place === length ? found : null;
      if (place + value.length > length) {
        await reader.cancel();
        return null;
      }
      found.set(value, place);
      place += value.length;
    }
  } catch {
    return null;
  }
}
