// What the page is to do: points of a face by name, in photographs and on surfaces.

export type Pixel = readonly [number, number];
export type Point = readonly [number, number, number];

/** A pinhole with one radial term: focal · y (1 + radial ‖y‖²) + centre, y = (R X + t)₀₁ / (…)₂. */
export interface Camera {
  readonly focal: number; // pixels
  readonly centre: Pixel;
  readonly radial: number;
  readonly rotation: readonly number[]; // R, row by row
  readonly translation: Point;
}

export type Kind = 'photograph' | 'template' | 'scan';

/** One thing to place points on. */
export interface Place {
  readonly key: string;
  readonly kind: Kind;
  /** Name of the file, without its folder. */
  readonly name: string;
  /** What a photograph is of; empty for surfaces. */
  readonly pose: string;
  /** Address of the photograph or of the surface, or `#id` of the element that holds it. */
  readonly source: string;
  readonly images: readonly string[]; // textures of a surface
  readonly camera: Camera | null;
}

/**
 * Where a point is: in pixels of the upright photograph, the middle of the first at (0, 0), or in
 * coordinates of the surface, with its vertex on a template.
 */
export interface Mark {
  readonly at: readonly number[];
  readonly vertex?: number;
}

/** Marks by place and by name of the point. */
export type Marks = Readonly<Record<string, Readonly<Record<string, Mark>>>>;

/** A file of landmarks, version 1, as Python reads and writes it. */
export interface LandmarkFile {
  readonly version: 1;
  readonly vertices: Readonly<Record<string, number>>;
  readonly photographs: Readonly<Record<string, Table>>;
  readonly points: Table;
}

/** Places by name, and in each the numbers of a point by its name. */
export type Table = Readonly<Record<string, Readonly<Record<string, readonly number[]>>>>;

export interface Task {
  readonly title: string;
  /** What is asked for: names, and in words where each point is. */
  readonly names: readonly string[];
  readonly words: Readonly<Record<string, string>>;
  /** How many photographs are asked for each point. */
  readonly asked: number;
  readonly places: readonly Place[];
  /** What is known already; also of places that are not shown. */
  readonly known: LandmarkFile;
  /** Where marks are sent to; null where there is no server, and they are downloaded. */
  readonly save: string | null;
  /** What the file is called. */
  readonly file: string;
}
