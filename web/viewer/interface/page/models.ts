// Opens models: added to those there are, or shown in their place.
import { openFile } from '../../files/open';
import type { Model, Scene, Services } from '../../types/model';
import type { Opener } from './opening';

export interface Receiver {
  scene(): Scene | null;
  /** Shows another scene; `added` are the numbers of its models that were not there before. */
  replace(scene: Scene, added: readonly number[]): void;
}

/** The last of the openers: what none of the others takes is read as a GLB, or told why not. */
export function modelOpener(receiver: Receiver): Opener {
  return {
    accepts: '.glb,model/gltf-binary',
    fits: (files) => files.slice(0, 1),
    open: async (files) => {
      for (const file of files) {
        const model = await openFile(file.name, await file.arrayBuffer());
        const [scene, added] = joined(receiver.scene(), model);
        receiver.replace(scene, added);
      }
    },
  };
}

/** A model of as many vertices joins those there are; any other stands alone. */
export function joined(scene: Scene | null, model: Model): [Scene, number[]] {
  const fits = scene?.models[0]?.neutral.length === model.neutral.length;
  if (!scene || !fits) {
    const services = beside(scene?.services);
    const { name } = model;
    return [{ title: name, name, unit: '', models: [model], start: {}, services }, [0]];
  }
  const same = scene.models.findIndex(({ name }) => name === model.name);
  const models = same < 0 ? [...scene.models, model] : scene.models.with(same, model);
  return [{ ...scene, models }, [same < 0 ? models.length - 1 : same]];
}

/** What a command does for any face; the rest is about the rig that it was given. */
function beside(services: Services = {}): Services {
  const { open, live } = services;
  return { ...(open !== undefined && { open }), ...(live !== undefined && { live }) };
}
