// three.js: GLTFLoader keeps the extras of a mesh in its userData.
import { Follower } from './index.js';

/**
 * Bends a mesh whose sliders stand in `morphTargetInfluences`, as players of VRM and ARKit set
 * them. Anything else is left alone, so that `scene.traverse(bendMesh)` bends a character.
 */
export function bendMesh(mesh) {
  const { userData, morphTargetDictionary: numbers, morphTargetInfluences: influences } = mesh;
  if (influences && userData.elastomorph)
    Follower.of(mesh, userData, () => {
      // The dictionary has one number a name: of several targets of a name, the last.
      const names = influences.map((_, i) => userData.targetNames?.[i]);
      for (const name in numbers) names[numbers[name]] = name;
      return names;
    })?.follow(influences);
}
