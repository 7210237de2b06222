// Opens models: added to those there are, or shown in their place.
import { openFile } from '../../files/open';
import { performances } from '../../rig/clips';
import type { Clip, Model, Scene, Services } from '../../types/model';
import type { Opener } from './opening';

const SAME = 1e-6; // of D: what single precision loses between two exports

export interface Receiver {
  scene(): Scene | null;
  /**
   * Shows another scene; `added` are the numbers of its models that were not there before. With
   * performances that came with them it opens on the first.
   */
  replace(scene: Scene, added: readonly number[], came?: readonly Clip[]): Promise<void> | void;
}

/** The last of the openers: what none of the others takes is read as a GLB, or told why not. */
export function modelOpener(receiver: Receiver): Opener {
  return {
    accepts: '.glb,model/gltf-binary',
    fits: (files) => files.slice(0, 1),
    open: async (files) => {
      for (const file of files) {
        const model = await openFile(file.name, await file.arrayBuffer());
        await receiver.replace(...joined(receiver.scene(), model));
      }
    },
  };
}

/**
 * A model of as many vertices joins those there are, with its performances; any other stands alone.
 * A face that is there already only brings its performances.
 */
export function joined(scene: Scene | null, model: Model): [Scene, number[], Clip[]] {
  if (!scene || !joins(scene, model)) {
    const services = beside(scene?.services);
    const { name } = model;
    return [{ title: name, name, unit: '', models: [model], start: {}, services }, [0], []];
  }
  const same = scene.models.findIndex(({ name }) => name === model.name);
  const came = performances([model]);
  if (same < 0 && came.length > 0 && scene.models.some((one) => isAlike(one, model)))
    return [scene, [], came];
  const models = same < 0 ? [...scene.models, model] : scene.models.with(same, model);
  return [{ ...scene, models }, [same < 0 ? models.length - 1 : same], came];
}

/** Whether a model has as many vertices as those of a scene. */
export function joins(scene: Scene | null, model: Model | undefined): boolean {
  return scene?.models[0]?.neutral.length === model?.neutral.length;
}

/** Whether two files show one face, moved by the same sliders to the same targets. */
function isAlike(one: Model, other: Model): boolean {
  const near = SAME * one.diameter;
  const alike = (a: Float32Array, b?: Float32Array) =>
    a.length === b?.length && a.every((value, i) => Math.abs(value - b[i]!) <= near);
  return (
    one.sliders.join('\n') === other.sliders.join('\n') &&
    one.targets.length === other.targets.length &&
    alike(one.neutral, other.neutral) &&
    one.targets.every((target, i) => alike(target, other.targets[i]))
  );
}

/** What a command does for any face; the rest is about the rig that it was given. */
function beside(services: Services = {}): Services {
  const { open, live } = services;
  return { ...(open !== undefined && { open }), ...(live !== undefined && { live }) };
}
