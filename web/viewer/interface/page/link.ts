// A link to the view as it is now, and the view that a link asks for.
import { clipNamed } from '../../rig/clips';
import { copyText } from '../../../shared/clipboard';
import { element } from '../../../shared/element';
import type { ViewState } from '../../types/state';
import type { Context } from '../parts/part';
import { fitted, listed } from '../poses/fitting';
import { readView, type Seen, viewOf, written } from '../state/address';
import { understood } from '../state/checked';

export interface Link {
  readonly element: HTMLElement;
  copy(): void;
  /** The present view as words. */
  words(): string;
  /** A scene has started so: shows it as the address of the page asks, or else as the words do. */
  begin(start: ViewState, words: string): void;
}

/** What a page around this one says: where it is, so that a link to it can be made. */
interface Around {
  readonly elastomorph: 'address';
  readonly href: string;
}

export function createLink(context: Context): Link {
  const { store, stage, tell, say } = context;
  const framed = window.self !== window.top;
  let start: ViewState = store.get();
  let following = true; // until the first scene has begun, too
  let around = framed && !/^(https?|file):/.test(location.href) ? '' : location.href;

  const words = () => written(store.get(), start, stage.camera());
  const see = ({ patch, camera }: Seen) => {
    const sliders = context.scene()?.models[0]?.sliders ?? [];
    const told = (problem: string) => tell(`The link asks for what there is not: ${problem}.`);
    const asked = understood(patch, told);
    const fit = fitted([{ name: 'view', weights: asked.weights ?? {} }], sliders);
    const { clip } = asked;
    const known = clipNamed(context.scene()?.models ?? [], { ...store.get(), clip: clip ?? null });
    if (clip && !known) tell(`The view is of the take ${clip}, which is not kept with it: open its file.`);
    if (fit.unknown.length > 0) tell(`The link moves ${listed(fit.unknown)}, which this rig lacks.`);
    store.update({ ...viewOf(start), ...asked, weights: fit.poses[0]!.weights, playing: false });
    if (typeof camera === 'string') stage.look(camera);
    else if (camera) stage.goTo(camera);
    else stage.look('front');
  };
  const follow = (text: string): boolean => {
    following = true;
    try {
      const seen = readView(text);
      if (seen) see(seen);
      return seen !== null;
    } catch (error) {
      tell((error as Error).message);
      return false;
    } finally {
      following = false;
    }
  };
  const copy = async () => {
    if (!around) return tell('A link needs a page with an address: open this one by itself.');
    const address = `${around.replace(/#.*$/s, '')}#${words()}`;
    if (await copyText(address)) say('A link to this view is on the clipboard');
    else tell(`The browser does not let this page write to the clipboard: ${address}`);
  };
  addEventListener('hashchange', () => context.scene() && follow(location.hash));
  // Whoever goes on from a linked view is to find their own after loading the page again.
  store.subscribe(() => {
    if (following || !location.hash.startsWith('#view=')) return;
    window.history.replaceState(null, '', location.href.replace(/#.*$/s, ''));
  });
  addEventListener('message', ({ source, data }: MessageEvent<Around | null>) => {
    if (!framed || source !== window.parent || data?.elastomorph !== 'address') return;
    around = String(data.href);
    if (context.scene()) follow(new URL(around).hash);
  });

  return {
    element: element(
      'section',
      { class: 'block' },
      element('h2', {}, 'View'),
      element(
        'button',
        { type: 'button', 'aria-keyshortcuts': 'L', onclick: () => void copy() },
        'Copy link',
        element('kbd', { 'aria-hidden': 'true' }, 'L'),
      ),
    ),
    copy: () => void copy(),
    words,
    begin(from, kept) {
      start = from;
      if (!follow(location.hash) && kept) follow(kept);
      if (framed) window.parent.postMessage({ elastomorph: 'ready' }, '*');
    },
  };
}
