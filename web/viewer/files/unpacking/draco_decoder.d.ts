// What is used of Draco's decoder, which comes without types.
declare module 'three/addons/libs/draco/gltf/draco_wasm_wrapper.js' {
  interface Owned {
    readonly ptr: number;
  }
  interface Mesh extends Owned {
    num_points(): number;
    num_faces(): number;
  }
  interface Attribute extends Owned {
    num_components(): number;
  }
  interface Decoder {
    DecodeArrayToMesh(
      bytes: Uint8Array,
      length: number,
      into: Mesh,
    ): { ok(): boolean; error_msg(): string };
    GetAttributeByUniqueId(mesh: Mesh, id: number): Attribute;
    GetTrianglesUInt32Array(mesh: Mesh, bytes: number, at: number): boolean;
    GetAttributeDataArrayForAllPoints(
      mesh: Mesh,
      attribute: Attribute,
      kind: number,
      bytes: number,
      at: number,
    ): boolean;
  }
  export interface Draco {
    readonly Decoder: new () => Decoder;
    readonly Mesh: new () => Mesh;
    readonly HEAPU8: Uint8Array;
    readonly DT_INT8: number;
    readonly DT_UINT8: number;
    readonly DT_INT16: number;
    readonly DT_UINT16: number;
    readonly DT_UINT32: number;
    readonly DT_FLOAT32: number;
    _malloc(bytes: number): number;
  }
  const load: (settings: { wasmBinary: ArrayBuffer }) => Promise<Draco>;
  export default load;
}
