// The state a page starts with, before the scene has its say.
import { performances } from '../../rig/clips';
import type { Scene } from '../../types/model';
import type { ViewState } from '../../types/state';
import { understood } from './checked';

export const INITIAL: ViewState = {
  weights: {},
  t: 1,
  correctivesOff: [],
  mirror: false,
  arrangement: 'single',
  shown: [0],
  swipe: 0.5,
  ghost: false,
  onion: 0,
  orbits: false,
  picked: [],
  grab: false,
  pins: [],
  heat: false,
  against: 0,
  heatTop: null,
  wireframe: false,
  loops: false,
  shading: 'smooth',
  light: 'studio',
  headTurns: true,
  theme: 'system',
  playing: false,
  repeat: 'back and forth',
  timing: 'linear',
  seconds: 2,
  clip: null,
  clipTime: 0,
  live: false,
  poses: [],
  favourites: [],
  folded: [],
  takes: [],
  range: null,
  speed: 1,
  soundOffsets: {},
  methods: {},
};

/**
 * What a scene starts with: distances are measured from the truth where there is one, several models
 * stand side by side, and one file with a performance opens on it.
 *
 * @param still nothing may move by itself.
 * @param tell hears of parts of the scene's own start that make no sense.
 */
export function startOf(
  scene: Scene,
  still: boolean,
  tell: (problem: string) => void,
): Partial<ViewState> {
  const count = scene.models.length;
  const truth = scene.models.findIndex((model) => model.role === 'truth');
  const own = understood(scene.start, (problem) =>
    tell(`The page asks for a start that it cannot have: ${problem}.`),
  );
  return {
    weights: {},
    correctivesOff: [],
    picked: [],
    pins: [],
    clip: count > 1 ? null : (performances(scene.models)[0]?.name ?? null),
    clipTime: 0,
    poses: [],
    favourites: [],
    folded: [],
    takes: [],
    range: null,
    soundOffsets: {},
    methods: {},
    t: 1,
    arrangement: count > 1 ? 'side' : 'single',
    shown: scene.models.slice(0, 3).map((_, model) => model),
    against: truth >= 0 ? truth : Math.min(1, count - 1),
    heat: false,
    live: false,
    ...own,
    playing: (own.playing ?? false) && !still,
  };
}
