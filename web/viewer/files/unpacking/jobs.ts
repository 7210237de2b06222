// What the page asks of the worker that unpacks, and what it answers.

/** A view packed by meshoptimizer. */
export interface PackedView {
  readonly name: string; // for messages
  readonly bytes: Uint8Array;
  readonly count: number; // rows, or indices
  readonly stride: number; // bytes each
  readonly mode: string;
  readonly filter: string;
}

/** A mesh packed by Draco. */
export interface PackedMesh {
  readonly name: string; // for messages
  readonly bytes: Uint8Array;
  readonly attributes: readonly PackedAttribute[];
}

export interface PackedAttribute {
  readonly id: number; // of the attribute in the stream; -1 for the corners of triangles
  readonly componentType: number; // as glTF numbers them
  readonly width: number; // components
  readonly count: number; // elements
}

export interface Job {
  readonly views: readonly PackedView[];
  readonly meshes: readonly PackedMesh[];
  readonly draco: ArrayBuffer | null; // the decoder, where there are meshes
}

/** The bytes of each view, and of each attribute of each mesh; or what is wrong. */
export type Answer =
  | { readonly views: readonly Uint8Array[]; readonly meshes: readonly (readonly Uint8Array[])[] }
  | { readonly problem: string };
