// Which picture is in view: one photograph or surface at a time is decoded, the others are small.
import type { Strip } from './panels/strip';
import type { Pane } from './picture/pane';
import { decoded, PhotographPane, type Decoded, type PhotographView } from './picture/photograph';
import type { SurfaceView } from './picture/paint';
import { SurfacePane } from './picture/surface';
import { blobOf, surfaceOf } from './state/sources';
import type { Place } from './types/task';

const SMALL = 140; // pixels of the higher side of what is in the strip

export class Viewing {
  pane: Pane | null = null;
  private photograph: Decoded | null = null;
  private readonly looked = new Map<string, PhotographView | SurfaceView>();
  private readonly photographs = new PhotographPane();
  private place: Place | null = null;
  private wanted = 0;

  /** @param say what the page is busy with; null when it is done */
  constructor(private readonly say: (words: string | null) => void) {}

  get surface(): SurfacePane | null {
    return this.pane instanceof SurfacePane ? this.pane : null;
  }

  /** The picture of a place, once it is there; null where another was asked for meanwhile. */
  async open(place: Place): Promise<Pane | null> {
    const order = ++this.wanted;
    this.keep();
    this.say(`Opening ${place.name} …`);
    try {
      if (place.kind === 'photograph') {
        const file = await blobOf(place.source, place.name);
        if (order !== this.wanted) return null;
        const photograph = await readable(file, place.name);
        if (order !== this.wanted) {
          close(photograph);
          return null;
        }
        this.photograph = photograph;
        this.photographs.show(photograph, (this.looked.get(place.key) as PhotographView) ?? null);
        this.pane = this.photographs;
      } else {
        const { mesh, images } = await surfaceOf(place);
        if (order !== this.wanted) return null;
        const view = (this.looked.get(place.key) as SurfaceView) ?? null;
        this.pane = new SurfacePane(mesh, images, place.kind === 'template', view);
      }
      this.place = place;
    } finally {
      if (order === this.wanted) this.say(null);
    }
    return this.pane;
  }

  /** A small picture of what is in view and was drawn just now, for the strip. */
  small(number: number, strip: Strip): void {
    if (strip.has(number) || !this.pane) return;
    const { photograph, pane } = this;
    strip.picture(number, photograph ? photograph.reduced : pane.canvas);
  }

  /** Small pictures of the other photographs, one after another while there is nothing else to do. */
  async fill(places: readonly Place[], strip: Strip): Promise<void> {
    for (const [number, place] of places.entries()) {
      if (place.kind !== 'photograph' || strip.has(number)) continue;
      await new Promise((done) => setTimeout(done, 30));
      try {
        const file = await blobOf(place.source, place.name);
        const small = await createImageBitmap(file, { resizeHeight: SMALL, resizeQuality: 'medium' });
        if (!strip.has(number)) strip.picture(number, small);
        small.close();
      } catch {
        // It is said when the photograph is opened.
      }
    }
  }

  /** Remembers from where the picture in view is looked at, and gives its memory back. */
  private keep(): void {
    const { place, surface } = this;
    const view = surface ? surface.looked : this.photographs.looked;
    if (place && view) this.looked.set(place.key, view);
    else if (place) this.looked.delete(place.key);
    surface?.dispose();
    if (this.photograph) close(this.photograph);
    this.photographs.show(null, null);
    this.photograph = this.place = this.pane = null;
  }
}

async function readable(file: Blob, name: string): Promise<Decoded> {
  try {
    return await decoded(file);
  } catch {
    throw new Error(`${name} is no photograph that this browser can read; save it as JPEG or PNG.`);
  }
}

function close({ full, reduced }: Decoded): void {
  full.close();
  reduced.close();
}
