// Performances in archives of NumPy: arrays names (N,), times (T,) in seconds and weights (T, N).
import { DataUtils } from 'three';
import { grouped, refuse } from '../files/container';
import type { Recording } from '../types/model';
import { rateOf } from './csv/columns';

const [LOCAL, CENTRAL, END] = [0x04034b50, 0x02014b50, 0x06054b50];
const [STORED, DEFLATED] = [0, 8];
const MOST = 2 ** 28; // bytes of one array
const AGAIN = 'Save it again with numpy.savez.';

interface Member {
  readonly packed: Uint8Array<ArrayBuffer>;
  readonly method: number;
}

export async function readNpz(name: string, bytes: ArrayBuffer): Promise<Recording> {
  const members = membersOf(name, bytes);
  const read = async (key: string) => {
    const member = members.get(`${key}.npy`);
    if (!member) {
      const found = [...members.keys()]
        .map((own) => own.replace(/\.npy$/, ''))
        .slice(0, 8)
        .join(', ');
      refuse(
        name,
        `there is no array "${key}"${found ? `; found ${found}` : ''}. A take has names (N,), times ` +
          '(T,) in seconds and weights (T, N).',
      );
    }
    return arrayOf(name, `the array "${key}"`, await unpacked(name, key, member));
  };
  const [names, times, weights] = [await read('names'), await read('times'), await read('weights')];
  const rate = members.has('rate.npy') ? await read('rate') : null;
  if (!Array.isArray(names.values)) refuse(name, `"names" holds no text. ${AGAIN}`);
  if ([times, weights, rate].some((own) => Array.isArray(own?.values)))
    refuse(name, `"times", "weights" and "rate" must be numbers. ${AGAIN}`);
  const [frames, count] = [times.values.length, names.values.length];
  const shapes = [names, times, weights].map(({ shape }) => shape.join());
  if (frames === 0 || shapes.join(' ') !== `${count} ${frames} ${frames},${count}`)
    refuse(
      name,
      'expected names (N,), times (T,) and weights (T, N), found ' +
        `${[names, times, weights].map(({ shape }) => `(${shape.join(', ')})`).join(', ')}. ${AGAIN}`,
    );
  requireNumbers(name, names.values, times.values as Numbers, weights.values as Numbers);
  const fps = rate ? Number(rate.values[0]) : rateOf(times.values as Numbers);
  if (!(fps > 0 && fps < Infinity) || (rate && rate.shape.length > 0))
    refuse(name, `"rate" must be one number above 0. ${AGAIN}`);
  return {
    names: names.values,
    times: times.values as Numbers,
    weights: weights.values as Numbers,
    rate: fps,
    timecodes: [],
  };
}

function requireNumbers(
  name: string,
  names: readonly string[],
  times: Float64Array,
  weights: Float64Array,
): void {
  const twice = names.find((own, i) => names.indexOf(own) < i);
  if (twice !== undefined) refuse(name, `the weight ${twice} is there twice. Rename one of them.`);
  const bad = weights.findIndex((own) => !Number.isFinite(own));
  if (bad >= 0)
    refuse(
      name,
      `${names[bad % names.length]} is not finite in frame ${grouped(Math.floor(bad / names.length))}. ` +
        'Correct it.',
    );
  const back = times.findIndex(
    (own, i) => !Number.isFinite(own) || (i > 0 && own <= times[i - 1]!),
  );
  if (back >= 0)
    refuse(name, `times must be finite and rise, but not in frame ${grouped(back)}. Correct it.`);
}

/** What the directory at the end of an archive lists. */
function membersOf(name: string, bytes: ArrayBuffer): Map<string, Member> {
  const view = new DataView(bytes);
  let end = bytes.byteLength - 22;
  while (end >= 0 && end > bytes.byteLength - 65_558 && view.getUint32(end, true) !== END) end -= 1;
  const found = new Map<string, Member>();
  try {
    if (view.getUint32(end, true) !== END) throw new RangeError();
    let place = view.getUint32(end + 16, true);
    for (let left = view.getUint16(end + 10, true); left > 0; left -= 1) {
      if (view.getUint32(place, true) !== CENTRAL) throw new RangeError();
      const [length, extra, comment] = [28, 30, 32].map((at) => view.getUint16(place + at, true));
      const own = new TextDecoder().decode(new Uint8Array(bytes, place + 46, length));
      const local = view.getUint32(place + 42, true);
      if (view.getUint32(local, true) !== LOCAL) throw new RangeError();
      const start =
        local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true);
      const packed = new Uint8Array(bytes, start, view.getUint32(place + 20, true));
      found.set(own, { packed, method: view.getUint16(place + 10, true) });
      place += 46 + length! + extra! + comment!;
    }
  } catch {
    refuse(name, 'this is no whole .npz archive: it is damaged or cut off. Copy it again.');
  }
  return found;
}

async function unpacked(
  name: string,
  key: string,
  { packed, method }: Member,
): Promise<Uint8Array> {
  if (method === STORED) return packed;
  if (method !== DEFLATED)
    refuse(name, `"${key}" is packed in a way that NumPy does not write. ${AGAIN}`);
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let size = 0;
  try {
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
    const reader = stream.getReader();
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return new Uint8Array(await new Blob(parts).arrayBuffer());
      parts.push(value);
      if ((size += value.length) > MOST) break;
    }
    await reader.cancel();
  } catch {
    refuse(name, `"${key}" is damaged and cannot be unpacked. Copy the file again.`);
  }
  refuse(name, `"${key}" is larger than ${MOST / 2 ** 20} MiB. Cut the take into parts.`);
}

type Numbers = Float64Array<ArrayBuffer>;

interface Values {
  readonly values: Numbers | string[];
  readonly shape: readonly number[];
}

/** An array of numbers or text; nothing else is read. */
function arrayOf(name: string, what: string, bytes: Uint8Array): Values {
  const magic = new TextDecoder().decode(bytes.subarray(1, 6));
  if (bytes.length < 12 || bytes[0] !== 0x93 || magic !== 'NUMPY')
    refuse(name, `${what} is damaged. ${AGAIN}`);
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const long = view.getUint8(6) > 1;
  const body = long ? 12 + view.getUint32(8, true) : 10 + view.getUint16(8, true);
  const header = new TextDecoder('latin1').decode(bytes.subarray(10, body));
  const kind = /'descr':\s*'([<>|=])([fiuU])(\d+)'/.exec(header);
  const shape = /'shape':\s*\(([\d, ]*)\)/.exec(header)?.[1]?.match(/\d+/g)?.map(Number) ?? [];
  const reader = kind && READERS[`${kind[2]}${kind[2] === 'U' ? '' : kind[3]}`];
  if (!reader) refuse(name, `${what} holds neither numbers of up to 64 bits nor text. ${AGAIN}`);
  const count = shape.reduce((product, length) => product * length, 1);
  const width = Number(kind[3]) * (kind[2] === 'U' ? 4 : 1);
  if (count * width > bytes.length - body) refuse(name, `${what} is cut off. Copy the file again.`);
  const little = kind[1] !== '>';
  if (kind[2] === 'U') {
    const letters = (i: number) =>
      Array.from({ length: width / 4 }, (_, j) => reader(view, body + i * width + 4 * j, little))
        .filter((code) => code > 0 && code < 0x110000)
        .map((code) => String.fromCodePoint(code));
    return { values: Array.from({ length: count }, (_, i) => letters(i).join('')), shape };
  }
  // Column by column, as NumPy stores what was transposed.
  const [rows = 1, columns = 1] = /'fortran_order':\s*True/.test(header) ? shape : [count];
  const place = (i: number) => Math.floor(i / columns) + (i % columns) * rows;
  return {
    values: Float64Array.from({ length: count }, (_, i) => reader(view, body + place(i) * width, little)),
    shape,
  };
}

type Reader = (view: DataView, at: number, little: boolean) => number;

const READERS: Readonly<Record<string, Reader>> = {
  U: (view, at, little) => view.getUint32(at, little),
  f2: (view, at, little) => DataUtils.fromHalfFloat(view.getUint16(at, little)),
  f4: (view, at, little) => view.getFloat32(at, little),
  f8: (view, at, little) => view.getFloat64(at, little),
  i1: (view, at) => view.getInt8(at),
  i2: (view, at, little) => view.getInt16(at, little),
  i4: (view, at, little) => view.getInt32(at, little),
  i8: (view, at, little) => Number(view.getBigInt64(at, little)),
  u1: (view, at) => view.getUint8(at),
  u2: (view, at, little) => view.getUint16(at, little),
  u4: (view, at, little) => view.getUint32(at, little),
  u8: (view, at, little) => Number(view.getBigUint64(at, little)),
};
