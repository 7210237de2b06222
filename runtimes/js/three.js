// three.js: GLTFLoader keeps the extras of a mesh in its userData.
import { curvesOf, Follower } from './index.js';

/**
 * Bends a mesh whose sliders stand in `morphTargetInfluences`, as players of VRM and ARKit set
 * them. Anything else is left alone, so that `scene.traverse(bendMesh)` bends a character.
 */
export function bendMesh(mesh) {
  const { userData, morphTargetInfluences: influences } = mesh;
  if (influences && userData.elastomorph)
    Follower.of(mesh, userData, () => targetsOf(mesh))?.follow(influences);
}

/** Gives the meshes of a scene whose file has no curves those of a file beside it. */
export function addCurves(scene, curves) {
  scene.traverse((mesh) => {
    const found = mesh.morphTargetInfluences && curvesOf(curves, targetsOf(mesh));
    if (found) mesh.userData.elastomorph = found.elastomorph;
  });
}

function targetsOf({ userData, morphTargetDictionary: numbers, morphTargetInfluences }) {
  // The dictionary has one number a name: of several targets of a name, the last.
  const names = morphTargetInfluences.map((_, i) => userData.targetNames?.[i]);
  for (const name in numbers) names[numbers[name]] = name;
  return names;
}
