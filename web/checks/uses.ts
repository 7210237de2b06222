// Compiled, never run: programs with types that use the package for engines.
import { registerGLTFExtension } from '@babylonjs/loaders/glTF/2.0/glTFLoaderExtensionRegistry';
import type { Scene as BabylonScene } from '@babylonjs/core/scene';
import { Bender, bendWeights, type Curves, curvesOf, Follower, type MeshExtras } from 'elastomorph';
import { bendMesh as bendBabylon, keepExtras } from 'elastomorph/babylon';
import { addCurves, bendMesh } from 'elastomorph/three';
import { Mesh, type Scene } from 'three';

export function withThree(scene: Scene): void {
  scene.traverse(bendMesh);
  bendMesh(new Mesh());
}

export function beside(scene: Scene, curves: Curves): Bender {
  addCurves(scene, curves);
  return new Bender(curvesOf(curves, 'face')!);
}

export function withBabylon(scene: BabylonScene): void {
  registerGLTFExtension('elastomorph', false, keepExtras);
  scene.onBeforeRenderObservable.add(() => scene.meshes.forEach(bendBabylon));
}

export function without(extras: MeshExtras): number {
  const bender = new Bender(extras, ['jawOpen', 'jawOpen.bend1']);
  const single: Float32Array = bender.weights([0.5], new Float32Array(2));
  const list: number[] = bender.weights(bender.values({ jawOpen: 0.5 }), [0, 0]);
  const double: Float64Array = bendWeights(extras, { jawOpen: 0.5 });
  new Follower(bender).follow(list);
  // @ts-expect-error: sliders are numbers
  bendWeights(extras, { jawOpen: '0.5' });
  return single[0]! + double[0]!;
}
