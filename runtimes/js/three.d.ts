/**
 * Bends a mesh whose sliders stand in `morphTargetInfluences`: reads them, and writes the weights
 * of all its morph targets there. Twice is as once. Objects without bends are left alone, so that
 * `scene.traverse(bendMesh)` bends a character.
 * One whose extras do not fit it is left alone too, with a warning the first time.
 */
export function bendMesh(mesh: object): void;
