// What makes takes of others: steps of the undo need no room for curves that stay as they are, nor for
// those frames of a curve that do.
import type { Clip } from '../types/model';
import { inFile, isInFile } from './carrying';

/** From a frame on, values of a curve that are others; null where there is no curve. */
type Piece = readonly [start: number, values: Float32Array] | null;

interface Patch {
  readonly pieces: ReadonlyMap<string, Piece>; // by slider
  readonly filed: boolean;
}

export interface Exchange {
  readonly names: readonly string[]; // of the takes there will be, in order
  readonly changes: ReadonlyMap<string, Clip | Patch>; // of those that are others
  readonly bytes: number;
}

/** What makes the one list of takes into the other. */
export function exchange(from: readonly Clip[], to: readonly Clip[]): Exchange {
  const changes = new Map<string, Clip | Patch>();
  let bytes = 0;
  for (const take of to) {
    const other = from.find(({ name }) => name === take.name);
    if (other === take) continue;
    if (other?.times !== take.times || other.recorded !== take.recorded) {
      changes.set(take.name, take);
      bytes += (take.recorded?.weights.byteLength ?? 0) + 4 * take.times.length * take.tracks.size;
      continue;
    }
    const pieces = piecesOf(other, take);
    changes.set(take.name, { pieces, filed: isInFile(take) });
    for (const piece of pieces.values()) bytes += piece?.[1].byteLength ?? 0;
  }
  return { names: to.map(({ name }) => name), changes, bytes };
}

/** The takes that an exchange makes of those it was made for. */
export function exchanged(takes: readonly Clip[], { names, changes }: Exchange): readonly Clip[] {
  return names.flatMap((name) => {
    const [take, change] = [takes.find((one) => one.name === name), changes.get(name)];
    if (change && 'name' in change) return [change];
    if (!take || !change) return take ?? [];
    const tracks = new Map(take.tracks);
    for (const [slider, piece] of change.pieces) {
      if (!piece) {
        tracks.delete(slider);
        continue;
      }
      const track = tracks.get(slider)?.slice() ?? new Float32Array(take.times.length);
      track.set(piece[1], piece[0]);
      tracks.set(slider, track);
    }
    const made = { ...take, tracks };
    if (change.filed) inFile(made);
    return [made];
  });
}

function piecesOf(from: Clip, to: Clip): Map<string, Piece> {
  const pieces = new Map<string, Piece>();
  for (const slider of from.tracks.keys()) if (!to.tracks.has(slider)) pieces.set(slider, null);
  for (const [slider, track] of to.tracks) {
    const other = from.tracks.get(slider);
    if (other === track) continue;
    let [first, end] = [0, track.length];
    if (other) {
      while (first < end && other[first] === track[first]) first += 1;
      while (end > first && other[end - 1] === track[end - 1]) end -= 1;
    }
    pieces.set(slider, [first, track.slice(first, end)]);
  }
  return pieces;
}
