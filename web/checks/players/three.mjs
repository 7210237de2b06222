// What three.js shows of a file.
import { AnimationMixer, LoopOnce, Vector3 } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { bendMesh } from '../../../runtimes/js/three.js';

export async function load(content) {
  const { scene, animations, parser } = await new GLTFLoader().parseAsync(content, '');
  const meshes = [];
  scene.traverse((object) => {
    if (object.isMesh && object.morphTargetInfluences) meshes.push(object);
  });
  const mixer = new AnimationMixer(scene);
  return {
    parts: meshes.map((mesh) => part(mesh, parser)),
    stop: () => mixer.stopAllAction(),
    play(number, time) {
      // A clip in a loop is at its start again when it ends.
      const clip = animations.find(({ name }) => name === `clip${number}`);
      const action = mixer.clipAction(clip).reset().setLoop(LoopOnce);
      action.clampWhenFinished = true;
      action.play();
      mixer.setTime(time);
    },
    update: () => scene.updateMatrixWorld(true),
  };
}

function part(mesh, parser) {
  const { count } = mesh.geometry.attributes.position;
  let shown = mesh;
  while (parser.associations.get(shown)?.nodes === undefined) shown = shown.parent;
  return {
    node: parser.associations.get(shown).nodes,
    primitive: parser.associations.get(mesh).primitives ?? 0,
    count,
    setWeights(weights) {
      weights.forEach((weight, i) => {
        mesh.morphTargetInfluences[i] = weight;
      });
    },
    bend: () => bendMesh(mesh),
    positions() {
      const found = new Float64Array(3 * count);
      const vertex = new Vector3();
      for (let i = 0; i < count; i += 1) {
        mesh.localToWorld(mesh.getVertexPosition(i, vertex)).toArray(found, 3 * i);
      }
      return found;
    },
  };
}
