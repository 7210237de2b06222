/** A piecewise polynomial: between breaks i and i + 1 it is Σ_n coefficients[i][n] (t − breaks[i])^n. */
export interface Curve {
  readonly breaks: readonly number[];
  readonly coefficients: readonly (readonly number[])[];
}

/** What a bent file says of a path. */
export interface DescribedMorph {
  readonly name: string;
  readonly target?: string; // a pair bend has none
  readonly index?: number; // of the target, where others of the mesh have its name too
  readonly fold?: Curve;
  readonly bends?: readonly {
    readonly target: string;
    readonly index?: number;
    readonly curve: Curve;
  }[];
}

/** How the time of a corrective comes of the weights of its drivers. */
export type Law =
  | 'product'
  | 'min'
  | 'softmin'
  | 'hinge'
  | 'allMul'
  | 'extMul'
  | 'mulAvgExt'
  | 'mulAvgAll';

/** What a bent file says of a morph that several sliders drive. */
export interface DescribedCorrective {
  readonly name: string;
  readonly drivers: readonly string[];
  readonly law?: Law; // product where there is none
  readonly gains?: readonly number[]; // of hinge, one a driver
  readonly sharpness?: number; // of softmin, above 0
}

/** The extras of a glTF mesh. What does not fit is refused when it is read. */
export interface MeshExtras {
  readonly targetNames?: readonly string[];
  readonly elastomorph?: {
    readonly version: number;
    readonly morphs?: readonly DescribedMorph[];
    readonly correctives?: readonly DescribedCorrective[];
  };
}

/** Values of sliders by name; one that a mesh does not have does nothing. */
export type Sliders = Readonly<Record<string, number>>;

/** Numbers that can be written in place: an array, or one of a fixed precision. */
export interface Numbers {
  readonly length: number;
  [index: number]: number;
}

/** t → b(t), straight on beyond 0 and 1. */
export interface Weighing extends Curve {
  (t: number): number;
}

/** A path: what its time, which its sliders give by a law, does to the weights of its targets. */
export interface Path {
  readonly name: string;
  /** Whose weight is t, and the fold of t where there is one; null of a pair bend. */
  readonly target: number | null;
  readonly fold: Weighing | null;
  readonly bends: readonly { readonly target: number; readonly curve: Weighing }[];
  readonly drivers: readonly number[]; // numbers of sliders
  readonly law: Law;
  readonly gains?: readonly number[] | undefined; // of hinge
  readonly sharpness?: readonly [number] | undefined; // of softmin
}

/** The weights of one mesh: made once, asked in every frame. */
export class Bender {
  /**
   * @param extras of a glTF mesh
   * @param targets names of its morph targets in order, where extras does not name them
   * @throws Error where the extras do not fit
   */
  constructor(extras: MeshExtras, targets?: readonly string[]);

  /** Names of the morph targets, in the order of their weights. */
  readonly targets: readonly string[];

  /** Names of the sliders, in the order of their values. */
  readonly sliders: readonly string[];

  /** For each slider, the number of its morph target: where programs without this one set it. */
  readonly sliderTargets: readonly number[];

  /** Every path, for those who need more than weights: derivatives, or single targets. */
  readonly morphs: readonly Path[];

  /** The values of the sliders in order; one that is not named is 0. */
  values(sliders: Sliders): number[];

  /** The time of each path, from the values of the sliders in order: new numbers. */
  times(values: ArrayLike<number>): Float64Array;

  /** The same, written into `out`, one a path, without allocation. */
  times<Out extends Numbers>(values: ArrayLike<number>, out: Out): Out;

  /** The weight of each morph target, from the values of the sliders in order: new numbers. */
  weights(values: ArrayLike<number>): Float64Array;

  /** The same, written into `out` without allocation. */
  weights<Out extends Numbers>(values: ArrayLike<number>, out: Out): Out;
}

/** What `elastomorph bend --curves` writes beside a character: the extras of each mesh that bends. */
export interface Curves {
  readonly version: number;
  readonly meshes: readonly (MeshExtras & {
    readonly mesh: number;
    readonly names: readonly string[];
    readonly targetNames: readonly string[];
  })[];
}

/**
 * The extras of a mesh in a file of curves: by its name, that of its node, its number, or the names
 * of its targets; of one mesh without any. Undefined where there is none, or several have the name.
 */
export function curvesOf(
  curves: Curves,
  mesh?: string | number | readonly string[],
): Curves['meshes'][number] | undefined;

/**
 * The weight of each morph target of a mesh, in the order of `targetNames`. The extras are read
 * once; where they do not fit, a warning says so once, and each target has the weight of the slider
 * of its name.
 */
export function bendWeights(extras: MeshExtras, sliders: Sliders): Float64Array;

/** Reads sliders where players set them, as weights of their targets, and writes all weights. */
export class Follower {
  constructor(bender: Bender);

  /**
   * The one of a mesh; where there is none, it is made from its extras and target names. Null, with
   * a warning the first time, where they do not fit.
   */
  static of(mesh: object, extras: MeshExtras, targets: () => readonly string[]): Follower | null;

  readonly bender: Bender;

  /** Numbers to read from and write to, where an engine has none of its own. */
  readonly influences: number[];

  /** Does so in place, without allocation. Twice is as once. */
  follow(influences?: Numbers): void;
}
