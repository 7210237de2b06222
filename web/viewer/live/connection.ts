// The WebSocket of "elastomorph live": poses and how the stream stands, and what people press back.

import { numbersByName } from '../../shared/named';
import type { Head } from '../types/model';

/** How the stream stands. */
export interface Standing {
  readonly words: string;
  readonly flows: boolean; // packets of the phone shown are coming
  readonly phones: readonly (readonly [number: number, name: string, shown: boolean])[];
  readonly records: boolean; // the command was given a file to record to
  readonly recording: boolean;
  readonly neutral: boolean; // a neutral is subtracted
}

export type Wish =
  | { watches: boolean }
  | { neutral: boolean }
  | { record: boolean }
  | { phone: number }
  | { drawn: number };

export interface Hearer {
  /** The connection is there: the moment to say what is wanted. */
  opened(): void;
  /** How the stream stands; null without a connection. */
  standing(found: Standing | null): void;
  /** A pose: the weight of each slider that is not 0. */
  pose(number: number, weights: Record<string, number>, head: Head): void;
}

export interface Connection {
  /** Nothing is kept for later: without a connection nobody hears it. */
  say(wish: Wish): void;
  close(): void;
}

const SOONEST = 500; // milliseconds until the first new try
const LATEST = 5000;

/** Connects, and again whenever the connection ends. */
export function connect(address: string, hearer: Hearer): Connection {
  let socket: WebSocket | null = null;
  let retry: ReturnType<typeof setTimeout> | undefined;
  let pause = SOONEST;
  let wanted = true;
  let sliders: readonly string[] = [];

  const hear = (text: string) => {
    const message = JSON.parse(text) as {
      sliders?: string[];
      status?: Standing;
      pose?: number;
      weights?: number[];
      head?: Head;
    };
    if (message.sliders) sliders = message.sliders;
    if (message.status) hearer.standing(message.status);
    if (message.pose === undefined || !message.weights || !message.head) return;
    const weights = numbersByName();
    message.weights.forEach((weight, slider) => {
      const name = sliders[slider];
      if (name !== undefined && weight !== 0) weights[name] = weight;
    });
    hearer.pose(message.pose, weights, message.head);
  };

  const open = () => {
    socket = new WebSocket(address);
    socket.addEventListener('open', () => {
      pause = SOONEST;
      hearer.opened();
    });
    socket.addEventListener('message', ({ data }) => hear(String(data)));
    socket.addEventListener('close', () => {
      if (!wanted) return;
      hearer.standing(null);
      retry = setTimeout(open, pause);
      pause = Math.min(LATEST, 2 * pause);
    });
  };
  open();

  return {
    say(wish) {
      if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(wish));
    },
    close() {
      wanted = false;
      clearTimeout(retry);
      socket?.close();
    },
  };
}
