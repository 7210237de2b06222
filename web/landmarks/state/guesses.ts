// What solved cameras say of a point: where it should be here, and how far off its marks are.
import { lineOfSight, lookedAt, project, triangulated, type Sight } from '../geometry/cameras';
import type { Camera, Marks, Pixel, Place, Point } from '../types/task';

const OFF = 0.006; // of the focal length: about 4 mm at 0.7 m is no slip of the hand

export interface Guess {
  /** Where the other photographs put the point here; null where fewer than two have it. */
  readonly pixel: Pixel | null;
  /** Where it may be, where just one other photograph has it. */
  readonly line: readonly Pixel[];
}

export class Guesses {
  private readonly seen: readonly (Place & { readonly camera: Camera })[];
  /** What was found is true as long as the marks are the same. */
  private known: { marks: Marks | null; points: Map<string, Point | null> } = {
    marks: null,
    points: new Map(),
  };
  private readonly middles = new Map<string, ReturnType<typeof lookedAt>>();

  constructor(places: readonly Place[]) {
    this.seen = places.filter((place): place is Place & { camera: Camera } => place.camera !== null);
    for (const pose of new Set(this.seen.map((place) => place.pose))) {
      const own = this.seen.filter((place) => place.pose === pose);
      this.middles.set(pose, lookedAt(own.map(({ camera }) => camera)));
    }
  }

  get any(): boolean {
    return this.seen.length > 0;
  }

  of(place: Place, name: string, marks: Marks): Guess {
    const none = { pixel: null, line: [] };
    if (!place.camera) return none;
    const others = this.sights(place.pose, name, marks, place.key);
    const point = triangulated(others);
    if (point) return { pixel: project(place.camera, point), line: [] };
    const middle = this.middles.get(place.pose);
    if (others.length !== 1 || !middle) return none;
    return { pixel: null, line: lineOfSight(others[0]!, place.camera, middle) };
  }

  /** Distance in pixels of a mark from where all photographs together put its point. */
  residual(place: Place, name: string, marks: Marks): { pixels: number; off: boolean } | null {
    const at = marks[place.key]?.[name]?.at;
    const point = place.camera && at && this.point(place.pose, name, marks);
    const pixel = point && project(place.camera!, point);
    if (!pixel) return null;
    const pixels = Math.hypot(pixel[0] - at[0]!, pixel[1] - at[1]!);
    return { pixels, off: pixels > OFF * place.camera!.focal };
  }

  /** Where all photographs together put a point. */
  private point(pose: string, name: string, marks: Marks): Point | null {
    if (this.known.marks !== marks) this.known = { marks, points: new Map() };
    const { points } = this.known;
    const key = `${pose}/${name}`;
    if (!points.has(key)) points.set(key, triangulated(this.sights(pose, name, marks)));
    return points.get(key) ?? null;
  }

  private sights(pose: string, name: string, marks: Marks, without = ''): Sight[] {
    return this.seen.flatMap(({ key, camera, pose: own }) => {
      const at = marks[key]?.[name]?.at;
      return at && own === pose && key !== without
        ? [{ camera, pixel: [at[0]!, at[1]!] as const }]
        : [];
    });
  }
}
