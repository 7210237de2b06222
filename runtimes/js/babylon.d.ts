/**
 * The factory of a loader extension that keeps what the glTF loader of Babylon.js would drop: the
 * extras of meshes, in their metadata. Once, before anything is loaded:
 *
 * ```js
 * registerGLTFExtension('elastomorph', false, keepExtras);
 * ```
 */
export function keepExtras(loader: object): {
  readonly name: string;
  enabled: boolean;
  dispose(): void;
};

/**
 * Bends a mesh whose sliders stand in the influences of its morph targets: reads them, and writes
 * the influences of all. Twice is as once. Meshes without bends are left alone, so that
 * `scene.meshes.forEach(bendMesh)` bends a character.
 * One whose extras do not fit it is left alone too, with a warning the first time.
 */
export function bendMesh(mesh: object): void;
