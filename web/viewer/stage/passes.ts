// In which passes the parts of a dressed face are drawn, and in which order what blends is.
import { BackSide, DoubleSide, FrontSide, type BufferGeometry, type Matrix4, type Side } from 'three';
import type { Model, Part, Skin } from '../types/model';

/** One drawing of a part. */
export interface Pass {
  readonly part: number;
  readonly skin: Skin;
  readonly side: Side;
  /** What is solid of a part that blends goes first, and hides what is behind it. */
  readonly kind: 'solid' | 'core' | 'clear';
}

export function passesOf(parts: readonly Part[]): Pass[] {
  return parts.flatMap(({ skin, shown }, part): Pass[] => {
    if (!skin || !shown) return [];
    const both = skin.doubleSided ? DoubleSide : FrontSide;
    if (skin.opacity !== 'blend') return [{ part, skin, side: both, kind: 'solid' }];
    const sides = skin.doubleSided ? [BackSide, FrontSide] : [FrontSide];
    const clear = sides.map((side): Pass => ({ part, skin, side, kind: 'clear' }));
    // A toon says by its queue what lies over what, brows over hair before them too.
    return skin.shading === 'toon' ? clear : [{ part, skin, side: both, kind: 'core' }, ...clear];
  });
}

/** Sorts what blends, of one rank, from far to near. */
export class Sorting {
  private readonly middles: ReadonlyMap<number, readonly number[]>;
  private readonly ranks: ReadonlyMap<number, number>;

  constructor(
    private readonly geometry: BufferGeometry,
    { parts, neutral, triangles }: Model,
    passes: readonly Pass[],
  ) {
    const clear = [...passes.entries()].filter(([, { kind }]) => kind === 'clear');
    this.ranks = new Map(clear.map(([number, { skin }]) => [number, skin.rank]));
    this.middles = new Map(
      clear.map(([number, { part }]) => [number, middleOf(neutral, triangles, parts[part]!)]),
    );
  }

  /** As seen by a camera; `view` is the map from the model to its space. */
  sort({ elements: m }: Matrix4): void {
    if (this.ranks.size < 2) return;
    const nearness = (number: number) => {
      const [x, y, z] = this.middles.get(number) as [number, number, number];
      return m[2]! * x + m[6]! * y + m[10]! * z;
    };
    const rank = (number: number) => this.ranks.get(number) ?? -Infinity;
    const number = (group: { materialIndex?: number | undefined }) => group.materialIndex ?? 0;
    this.geometry.groups.sort((one, other) => {
      const [a, b] = [number(one), number(other)];
      if (rank(a) !== rank(b)) return rank(a) - rank(b);
      return this.ranks.has(a) && this.middles.get(a) !== this.middles.get(b)
        ? nearness(a) - nearness(b) || a - b
        : a - b;
    });
  }
}

function middleOf(neutral: Float32Array, triangles: Uint32Array, part: Part): number[] {
  const sum = [0, 0, 0];
  for (let i = part.start; i < part.start + part.count; i += 1)
    for (let axis = 0; axis < 3; axis += 1) sum[axis]! += neutral[3 * triangles[i]! + axis]!;
  return sum.map((total) => total / part.count);
}
