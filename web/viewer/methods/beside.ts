// Models that stand beside the rig to be compared with it, and go when others are chosen.
import type { Model, Scene } from '../types/model';
import type { Context } from '../interface/parts/part';

export interface Beside {
  /** Puts models beside the rig, in the place of those that stood there. */
  put(models: readonly Model[]): void;
  /** Another model takes the place of the rig; nothing stands beside it. */
  rebase(model: Model): void;
}

/** @param replace shows a scene; `added` are the numbers of its models that were not there. */
export function createBeside(
  { scene }: Context,
  replace: (scene: Scene, added: readonly number[]) => void,
): Beside {
  let own: readonly Model[] = [];
  const others = () => (scene()?.models ?? []).filter((model) => !own.includes(model));
  const show = (models: readonly Model[], next: readonly Model[]) => {
    const found = scene();
    if (!found) return;
    own = next;
    replace({ ...found, models: [...models, ...next] }, next.map((_, i) => models.length + i));
  };
  return {
    put(models) {
      if (models.length > 0 || others().length < (scene()?.models.length ?? 0)) {
        show(others(), models);
      }
    },
    rebase: (model) => show([model, ...others().slice(1)], []),
  };
}
