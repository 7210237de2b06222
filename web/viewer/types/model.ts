// A face as the viewer knows it: plain arrays, without three.js and without the page.
import type { Bender } from '../../../runtimes/js/index.js';

/** A path to a target, whose weights the model's bender knows. */
export interface Morph {
  readonly name: string;
  readonly delta: number; // number of its morph target
  /** The weight of that target at a time of the path, where it is not the time itself. */
  readonly fold: ((t: number) => number) | null;
}

/** A recorded performance: the weight of each slider at each key. */
export interface Clip {
  readonly name: string;
  readonly times: Float64Array; // seconds, increasing
  readonly tracks: ReadonlyMap<string, Float32Array>; // by slider, as long as times
  /** As long as times, of a clip that turns the head; of a take, its columns do. */
  readonly heads?: readonly Head[];
  /** Of a take that was opened: what its file holds, and which weights drive which sliders. */
  readonly recorded?: Recording & { readonly drives: ReadonlyMap<string, readonly string[]> };
}

/**
 * How a head is turned, in radians as ARKit's angles of Live Link Face: to its own right, downwards,
 * and leaned to its own left.
 */
export type Head = readonly [yaw: number, pitch: number, roll: number];

/** Weights of a face over time as a file holds them. */
export interface Recording {
  readonly names: readonly string[];
  readonly times: Float64Array; // (T,) seconds, rising
  readonly weights: Float64Array; // (T, N)
  readonly rate: number; // frames a second, nominal
  readonly timecodes: readonly string[]; // T as Live Link Face writes them, or none
  readonly guessed?: string; // half a sentence about its units, where nothing but its numbers told them
}

/** An image laid over a surface. */
export interface Layer {
  readonly image: ImageBitmap;
  readonly wrap: readonly [Wrap, Wrap]; // beside the image, across and down
  readonly smooth: boolean; // whether what is between pixels is mixed
  /** Six numbers of the map from texture coordinates to the image, by columns. */
  readonly place: readonly number[];
  readonly set: number; // of the texture coordinates: 0 or 1
}

export type Wrap = 'repeat' | 'mirror' | 'clamp';

/** What images may say: colour and opacity, bumps, light, roughness and metal, creases, shade. */
export type LayerName = 'base' | 'bumps' | 'glow' | 'finish' | 'creases' | 'shade';

/** What a file says of the looks of a surface. */
export interface Skin {
  readonly layers: Readonly<Partial<Record<LayerName, Layer>>>;
  readonly colour: Colour4; // of the base
  readonly opacity: 'opaque' | 'mask' | 'blend';
  readonly cutoff: number; // least opacity that a mask shows
  readonly doubleSided: boolean;
  /** In light, as it is whatever the light, or in light and shade of two flat colours. */
  readonly shading: 'lit' | 'unlit' | 'toon';
  readonly bumps: number; // how high they are
  readonly glow: Colour3; // light of its own
  readonly roughness: number;
  readonly metal: number;
  readonly shine: number; // of what is no metal, 1 as usual
  readonly creases: number; // how dark they are
  readonly shade: Colour3; // of a toon
  readonly edge: readonly [number, number]; // of the shade: cosines to the light, from dark to lit
  /** Among what blends: lower ones are drawn first, and where they are alike the farther. */
  readonly rank: number;
  readonly covers: boolean; // whether what blends hides what is drawn after it and lies behind
}

type Colour3 = readonly [number, number, number];
type Colour4 = readonly [number, number, number, number];

/** Triangles that look alike. */
export interface Part {
  readonly name: string;
  readonly start: number; // first entry of triangles
  readonly count: number; // entries of triangles
  readonly colour: readonly [number, number, number]; // linear, 0 to 1
  readonly shine: number; // strength of the highlight, 0 to 1
  readonly shown: boolean; // false: shells of wetness or shadow that only an image can shade
  /** In a file that shows images or colours of its own: they take the place of the colour. */
  readonly skin?: Skin;
  /** An eyeball without an iris of its own: one is drawn on it. At rest it looks along +Z. */
  readonly eye?: { readonly middle: readonly [number, number, number]; readonly radius: number };
}

/** A curve on the surface, as the vertices it runs through. */
export interface Loop {
  readonly vertices: readonly number[];
  readonly closed: boolean;
}

/** One face with its paths. Vertices are numbered as in the file, copies at seams included. */
export interface Model {
  readonly name: string;
  readonly role: 'rig' | 'method' | 'truth';
  readonly neutral: Float32Array; // (V, 3)
  readonly triangles: Uint32Array; // (T, 3)
  /** (V, 2) texture coordinates, v from the top, in one or two sets; none without images. */
  readonly uv: readonly Float32Array[];
  readonly colours: Uint8Array | null; // (V, 4) what colours are multiplied with, linear
  readonly fileNormals: Float32Array | null; // (V, 3) of the neutral, where the file says how it looks
  readonly head: Uint8Array | null; // (V,) 1 at the head of a character with a body, else null
  /** (V,) the vertex that each vertex is a copy of, at a texture seam, or itself: one normal. */
  readonly seams: Uint32Array;
  readonly edges: Uint32Array; // (E, 2) edges of the polygons, without diagonals where these are known
  readonly parts: readonly Part[];
  readonly loops: readonly Loop[]; // none where nobody traced them
  /** (V, 3) displacement of each morph target. */
  readonly targets: readonly Float32Array[];
  readonly morphs: readonly Morph[]; // pair bends, which have no target, are none of them
  readonly groups: readonly { readonly name: string; readonly members: readonly string[] }[];
  /** From sliders to the weights of the targets. */
  readonly bender: Bender;
  /** What has a slider: every morph but the correctives that others drive entirely. */
  readonly sliders: readonly string[];
  readonly clips: readonly Clip[];
  readonly diameter: number; // D: largest distance between two vertices of the neutral
  readonly bytes: number; // of the file
  readonly notes: readonly string[]; // what is not as the file has it: a sentence each
  /** The file itself, which browsers keep out of the way; none of models made otherwise. */
  readonly file?: Blob;
}

/** What the command that shows a page does for it, and the address of each; none in a page alone. */
export type Services = Readonly<Partial<Record<'open' | 'methods' | 'save' | 'live', string>>>;

/** What a page was given to show. Models that are compared share their vertices. */
export interface Scene {
  readonly title: string;
  readonly name: string; // of the rig, whatever is done with it: its work is kept under it
  readonly unit: string; // of the coordinates, for legends; '' where unknown
  readonly models: readonly Model[];
  readonly start: Partial<import('./state').ViewState>;
  readonly services: Services;
}
