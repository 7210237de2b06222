/**
 * Bends a mesh whose sliders stand in `morphTargetInfluences`: reads them, and writes the weights
 * of all its morph targets there. Twice is as once. Objects without bends are left alone, so that
 * `scene.traverse(bendMesh)` bends a character.
 *
 * @throws Error where the extras of the mesh do not fit it
 */
export function bendMesh(mesh: object): void;
