/**
 * Bends a mesh whose sliders stand in `morphTargetInfluences`: reads them, and writes the weights
 * of all its morph targets there. Twice is as once. Objects without bends are left alone, so that
 * `scene.traverse(bendMesh)` bends a character.
 * One whose extras do not fit it is left alone too, with a warning the first time.
 */
export function bendMesh(mesh: object): void;

/**
 * Gives the meshes of a scene the curves of a file beside it, where pipelines have dropped theirs:
 * those of the mesh with targets of the same names.
 */
export function addCurves(
  scene: { traverse(callback: (object: any) => void): void },
  curves: import('./index.js').Curves,
): void;
