// What Babylon.js shows of a file, without a window.
import { FreeCamera, ImportMeshAsync, Logger, NullEngine, Scene, Vector3 } from '@babylonjs/core';
import '@babylonjs/loaders/glTF/index.js';
import { registerGLTFExtension } from '@babylonjs/loaders/glTF/2.0/glTFLoaderExtensionRegistry.js';
import { bendMesh, keepExtras } from '../../../runtimes/js/babylon.js';

const FRAMES = 60; // a second, which is what its loader counts in

const MOVED = ['position', 'rotationQuaternion', 'scaling'];

export async function load(content) {
  Logger.LogLevels = Logger.ErrorLogLevel; // what it greets with is no answer
  registerGLTFExtension('elastomorph', false, keepExtras);
  const engine = new NullEngine({ useHighPrecisionMatrix: true });
  const scene = new Scene(engine);
  scene.useRightHandedSystem = true;
  new FreeCamera('camera', Vector3.Zero(), scene);
  const loaded = await ImportMeshAsync(new Uint8Array(content), scene, { pluginExtension: '.glb' });
  for (const group of scene.animationGroups) group.stop();
  const meshes = loaded.meshes.filter((mesh) => mesh.morphTargetManager);
  const rest = scene.getNodes().map((node) => [node, ...MOVED.map((key) => node[key]?.clone?.())]);
  return {
    parts: meshes.map(part),
    stop() {
      for (const group of scene.animationGroups) group.stop();
      for (const [node, ...values] of rest) {
        MOVED.forEach((key, i) => values[i] && node[key].copyFrom(values[i]));
      }
    },
    play(number, time) {
      const group = scene.animationGroups.find(({ name }) => name === `clip${number}`);
      group.start(false, 1, group.from, group.to);
      group.pause();
      group.goToFrame(time * FRAMES);
    },
    update() {
      for (const node of scene.getNodes()) node.computeWorldMatrix?.(true);
      for (const skeleton of scene.skeletons) skeleton.prepare(true);
    },
  };
}

function part(mesh) {
  const [, node, primitive] = mesh.name.match(/^node(\d+)(?:_primitive(\d+))?$/);
  const targets = mesh.morphTargetManager;
  return {
    node: Number(node),
    primitive: Number(primitive ?? 0),
    count: mesh.getTotalVertices(),
    setWeights(weights) {
      weights.forEach((weight, i) => {
        targets.getTarget(i).influence = weight;
      });
    },
    bend: () => bendMesh(mesh),
    positions() {
      const posed = mesh.getPositionData(true, true);
      const found = new Float64Array(posed.length);
      const vertex = new Vector3();
      for (let i = 0; i < posed.length; i += 3) {
        Vector3.TransformCoordinatesToRef(Vector3.FromArray(posed, i), mesh.getWorldMatrix(), vertex);
        vertex.toArray(found, i);
      }
      return found;
    },
  };
}
