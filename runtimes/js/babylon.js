// Babylon.js: its glTF loader drops the extras of meshes, unless an extension keeps them.
import { Follower } from './index.js';

/** The factory of a loader extension that keeps them in the metadata of meshes. */
export function keepExtras(loader) {
  return {
    name: 'elastomorph',
    enabled: true,
    dispose() {},
    loadNodeAsync(context, node, assign) {
      const { elastomorph } = { ...node.extras, ...loader.gltf.meshes?.[node.mesh]?.extras };
      if (!elastomorph) return null;
      return loader.loadNodeAsync(context, node, assign).then((loaded) => {
        // One a primitive, as the extensions of Babylon.js itself find them.
        for (const mesh of node._primitiveBabylonMeshes ?? [])
          mesh.metadata = { ...mesh.metadata, elastomorph };
        return loaded;
      });
    },
  };
}

/**
 * Bends a mesh whose sliders stand in the influences of its morph targets. Meshes without bends
 * are left alone, so that `scene.meshes.forEach(bendMesh)` bends a character.
 */
export function bendMesh(mesh) {
  const { metadata, morphTargetManager: manager } = mesh;
  if (!manager || !metadata?.elastomorph) return;
  const follower = Follower.of(mesh, metadata, () =>
    Array.from({ length: manager.numTargets }, (_, i) => manager.getTarget(i).name),
  );
  if (!follower) return;
  const { influences } = follower;
  for (let i = 0; i < influences.length; i += 1) influences[i] = manager.getTarget(i).influence;
  follower.follow();
  for (let i = 0; i < influences.length; i += 1) manager.getTarget(i).influence = influences[i];
}
