// What people do with poses, each a change of the state.
import { copyText, download, pastedText } from '../../../shared/clipboard';
import type { NamedPose, ViewState } from '../../types/state';
import type { Context } from '../parts/part';
import { posed } from '../state/posing';
import { fitted, listed } from './fitting';
import {
  added,
  cleanName,
  duplicated,
  equalWeights,
  freshName,
  moved,
  type Poses,
  removed,
  renamed,
  saved,
} from './list';
import { mixed } from './mixing';
import { asJson, asTable, fromText } from './text';

const UNIT = [0, 1] as const;
const LARGEST = 2 ** 24; // bytes of a file of poses

export type Deeds = ReturnType<typeof poseDeeds>;

/** @param chosen hears which pose others are now done to; null for none. */
export function poseDeeds(
  { store, scene, tell, say }: Context,
  chosen: (name: string | null) => void,
) {
  // What the last pose was blended with, as long as nobody has moved anything since.
  let blend: { base: ViewState['weights']; pose: NamedPose; made: ViewState['weights'] } | null =
    null;

  const poses = (): Poses => store.get().poses;
  const named = (name: string) => poses().find((pose) => pose.name === name);
  const sliders = () => scene()?.models[store.get().shown[0] ?? 0]?.sliders ?? [];
  const change = (next: Poses, name: string | null) => {
    store.update({ poses: next });
    chosen(name);
  };
  const pose = (weights: ViewState['weights']) => store.update(posed(store.get(), weights));
  const take = (found: Poses) => {
    const fit = fitted(found, sliders());
    const before = poses();
    const next = added(before, fit.poses);
    const count = next.length - before.length;
    change(next, next.at(-1)?.name ?? null);
    say(count === 1 ? `“${next.at(-1)!.name}” is here` : `${count} poses are here`);
    if (fit.unknown.length > 0) tell(lacking(fit.unknown, 'the poses move is kept'));
  };
  const tried = (read: () => void) => {
    try {
      read();
    } catch (error) {
      tell((error as Error).message);
    }
  };

  return {
    save(text: string) {
      const wanted = cleanName(text);
      const { weights } = store.get();
      const same = wanted ? undefined : poses().find((pose) => equalWeights(pose.weights, weights));
      if (same) {
        chosen(same.name);
        say(`This is “${same.name}” already`);
        return;
      }
      const name = wanted || freshName(poses(), `Pose ${poses().length + 1}`);
      change(saved(poses(), name, weights), name);
    },
    load(name: string, strength: number, onTop: boolean) {
      const kept = named(name);
      if (!kept) return;
      const own = new Set(scene()?.models.flatMap((model) => model.sliders));
      const names = Object.keys(kept.weights);
      const known = names.filter((slider) => own.has(slider));
      const found = { name, weights: Object.fromEntries(known.map((s) => [s, kept.weights[s]!])) };
      if (known.length < names.length)
        tell(lacking(names.filter((slider) => !own.has(slider)), 'the pose moves is shown'));
      const base = store.get().weights;
      pose(mixed(base, found.weights, strength, onTop, UNIT));
      blend = { base, pose: found, made: store.get().weights };
      chosen(name);
    },
    /** Blends the pose that was loaded last anew. */
    blend(strength: number, onTop: boolean) {
      if (blend?.made !== store.get().weights) return;
      pose(mixed(blend.base, blend.pose.weights, strength, onTop, UNIT));
      blend = { ...blend, made: store.get().weights };
    },
    /** Whether it is called so now; a name that is taken changes nothing. */
    rename(from: string, text: string) {
      const to = cleanName(text);
      if (to === from || !to) return to === from;
      if (named(to)) {
        tell(`Another pose is called “${to}” already.`);
        return false;
      }
      change(renamed(poses(), from, to), to);
      return true;
    },
    duplicate: (name: string) => change(...duplicated(poses(), name)),
    move: (name: string, by: -1 | 1) => change(moved(poses(), name, by), name),
    remove(name: string) {
      const place = poses().findIndex((pose) => pose.name === name);
      const next = removed(poses(), name);
      change(next, next[Math.min(place, next.length - 1)]?.name ?? null);
    },
    async copy(name: string) {
      const found = named(name);
      if (!found) return;
      if (await copyText(asJson([found]))) say(`“${name}” is on the clipboard`);
      else tell('The browser does not let this page write to the clipboard: save JSON instead.');
    },
    async paste() {
      const text = await pastedText();
      if (text === null)
        tell('The browser does not let this page read the clipboard: press Ctrl+V instead.');
      else tried(() => take(fromText('The clipboard', text)));
    },
    /** Text that was pasted by the browser's own key. */
    takeText: (text: string) => tried(() => take(fromText('The clipboard', text))),
    async open(files: readonly File[]) {
      for (const file of files) {
        if (file.size > LARGEST)
          throw new Error(`${file.name}: this is too large for a file of poses.`);
        if (!scene()) throw new Error(`${file.name}: poses need a face; open that first.`);
        take(fromText(file.name, await file.text()));
      }
    },
    saveJson: () => download(`${fileName()}.json`, 'application/json', asJson(poses())),
    saveTable: () => download(`${fileName()}.csv`, 'text/csv', asTable(poses(), sliders())),
  };

  function fileName(): string {
    const title = scene()?.title.replace(/[^\p{L}\p{N}._-]+/gu, ' ').trim();
    return title ? `${title} poses` : 'poses';
  }
}

function lacking(sliders: readonly string[], rest: string): string {
  const what = sliders.length === 1 ? 'has no slider' : 'has none of the sliders';
  return `The rig ${what} ${listed(sliders)}; what else ${rest}.`;
}
