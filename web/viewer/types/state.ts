// Everything the picture depends on, as plain data: the interface changes it, the stage draws it.

import type { Clip } from './model';

export type Arrangement = 'single' | 'side' | 'swipe';
export type TimingName = 'linear' | 'smoothstep' | 'minimum-jerk' | 'cosine' | 'blink';

/** An expression that is kept under its name, which no other has; weights left out are 0. */
export interface NamedPose {
  readonly name: string;
  readonly weights: Readonly<Record<string, number>>;
}

export interface ViewState {
  /** Weight of each slider; those left out are 0. The parameter of its path is t times this. */
  readonly weights: Readonly<Record<string, number>>;
  /** Master time, 0 to 1. */
  readonly t: number;
  /** Correctives that the picture is without; those whose slider has their name are none. */
  readonly correctivesOff: readonly string[];
  /** Moving one of a symmetric pair moves the other. */
  readonly mirror: boolean;

  readonly arrangement: Arrangement;
  /** Numbers of the models shown: one for 'single', two for 'swipe', two or three for 'side'. */
  readonly shown: readonly number[];
  /** Where the picture is split, 0 to 1 of its width. */
  readonly swipe: number;

  readonly ghost: boolean; // the neutral, translucent
  readonly onion: number; // in-betweens drawn translucent between t = 0 and t = 1, 0 to 9
  readonly orbits: boolean; // the way of each picked vertex as t runs from 0 to 1
  readonly picked: readonly number[]; // vertices

  readonly grab: boolean; // pressing on the face drags it by its sliders
  readonly pins: readonly number[]; // vertices that hold still meanwhile

  readonly heat: boolean; // colours by the distance between each shown model and `against`
  readonly against: number; // number of a model
  /** Distance of the last colour as a fraction of D; null for the largest one found. */
  readonly heatTop: number | null;

  readonly wireframe: boolean;
  readonly loops: boolean;
  readonly shading: 'smooth' | 'flat';
  readonly light: 'studio' | 'matcap';
  /** Turned as a phone or a performance says, while one of them drives the picture. */
  readonly headTurns: boolean;
  readonly theme: 'system' | 'light' | 'dark';

  readonly playing: boolean;
  readonly repeat: 'once' | 'loop' | 'back and forth';
  readonly timing: TimingName;
  readonly seconds: number; // that t takes from 0 to 1
  /** Name of the performance that drives the sliders; null while people do. */
  readonly clip: string | null;
  readonly clipTime: number; // seconds
  /** A phone moves the sliders, through "elastomorph live". */
  readonly live: boolean;

  readonly poses: readonly NamedPose[];
  readonly favourites: readonly string[]; // sliders
  readonly folded: readonly string[]; // groups of sliders
  /** Performances opened or edited here; one of the name of a file's takes its place. */
  readonly takes: readonly Clip[];
  /** In and out point of the performance in seconds; null for the whole. */
  readonly range: readonly [number, number] | null;
  readonly speed: number; // of a performance, 0.1 to 2
  /** Seconds that the sound of a performance begins after it, by its name; 0 where left out. */
  readonly soundOffsets: Readonly<Record<string, number>>;

  /** Methods chosen for targets and not saved yet; '' for none of its own. */
  readonly methods: Readonly<Record<string, string>>;
}
