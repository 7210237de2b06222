// The face of a phone: moves the sliders while the state says so, and shows how its stream stands.
import type { Context, Part } from '../interface/parts/part';
import type { Head } from '../types/model';
import type { ViewState } from '../types/state';
import { element, setAttribute, setText } from '../../shared/element';
import { connect, type Connection, type Standing } from './connection';

const ENDED = 'the command that shows this page has ended, or is busy';

export function createLive({ store, stage }: Context): Part {
  let connection: Connection | null = null;
  let address: string | undefined;
  let standing: Standing | null = null;
  let heard = false; // of the command, by now
  let latest: { number: number; weights: Record<string, number>; head: Head } | null = null;
  let frame = 0;

  const follow = button('Live', 'Follow the phone', () => {
    const live = !store.get().live;
    store.update(live ? { live, clip: null, playing: false, t: 1 } : { live });
  });
  const phones = element('select', { 'aria-label': 'Phone', title: 'Phone' });
  phones.addEventListener('change', () => connection?.say({ phone: Number(phones.value) }));
  const neutral = button('Set as neutral', 'Subtract the present face from all that come', () =>
    connection?.say({ neutral: !standing?.neutral }),
  );
  const record = button('Record', 'Record into the file of the command', () =>
    connection?.say({ record: !standing?.recording }),
  );
  const flow = element('span', { class: 'flow', role: 'status' });
  const words = element('span', { class: 'words' });
  const whole = element(
    'div',
    { class: 'live', role: 'group', 'aria-label': 'Live', hidden: true },
    ...[follow, phones, neutral, record],
    element('p', {}, flow, words),
  );

  // The newest pose, once a frame; the mark goes back when the next frame begins.
  const draw = () => {
    frame = 0;
    const pose = latest;
    latest = null;
    if (!pose || !store.get().live) return;
    stage.turnHead(pose.head);
    store.update({ weights: pose.weights });
    stage.flush(false);
    requestAnimationFrame(() => connection?.say({ drawn: pose.number }));
  };

  const begin = (to: string) =>
    connect(to, {
      opened: () => connection?.say({ watches: store.get().live }),
      standing(found) {
        standing = found;
        heard ||= found !== null;
        show(store.get());
      },
      pose(number, weights, head) {
        latest = { number, weights, head };
        frame ||= requestAnimationFrame(draw);
      },
    });

  store.subscribe((state, previous) => {
    if (state.live !== previous.live) connection?.say({ watches: state.live });
  });

  const show = (state: ViewState) => {
    if (!connection) return;
    const there = standing !== null;
    press(follow, state.live);
    press(neutral, standing?.neutral ?? false);
    press(record, standing?.recording ?? false);
    record.hidden = !standing?.records;
    neutral.disabled = record.disabled = phones.disabled = !there;
    setText(flow, there || heard ? flowOf(standing) : 'Connecting…');
    setAttribute(whole, 'data-flows', standing?.flows);
    setText(words, standing?.words ?? (heard ? ENDED : ''));
    drawPhones(phones, standing);
  };

  return {
    element: whole,
    show,
    load(scene) {
      const next = scene?.services.live;
      if (next === address) return;
      connection?.close();
      address = next;
      [standing, heard] = [null, false];
      connection = next === undefined ? null : begin(next);
      whole.hidden = connection === null;
      show(store.get());
    },
  };
}

function flowOf(standing: Standing | null): string {
  if (!standing) return 'Not connected';
  if (standing.flows) return 'Receiving';
  return standing.phones.some(([, , shown]) => shown) ? 'Stopped' : 'Waiting';
}

function drawPhones(select: HTMLSelectElement, standing: Standing | null): void {
  const known = standing?.phones ?? [];
  select.hidden = known.length < 2;
  const now = JSON.stringify(known.map(([number, name]) => [number, name]));
  if (select.dataset.known !== now) {
    select.dataset.known = now;
    select.replaceChildren(
      ...known.map(([number, name]) => element('option', { value: number }, name)),
    );
  }
  const shown = known.find(([, , isShown]) => isShown);
  if (document.activeElement !== select) select.value = String(shown?.[0] ?? '');
}

function button(label: string, title: string, press: () => void): HTMLButtonElement {
  const made = element('button', { type: 'button', title, 'aria-pressed': 'false' }, label);
  made.addEventListener('click', press);
  return made;
}

function press(target: HTMLButtonElement, pressed: boolean): void {
  setAttribute(target, 'aria-pressed', String(pressed));
}
