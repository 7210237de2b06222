// What the page was given to do, and the file that comes of it.
import type { Camera, LandmarkFile, Mark, Marks, Place, Table, Task } from '../types/task';

const ID = 'elastomorph-landmarks';

/** @throws Error with a sentence for people */
export function taskOf(document: Document): Task {
  const text = document.getElementById(ID)?.textContent;
  let found: Task & { version: number; places: Omit<Place, 'key'>[] };
  try {
    found = JSON.parse(text ?? '');
  } catch {
    throw new Error('This page shows nothing by itself. Make one with "elastomorph landmarks".');
  }
  if (found.version !== 1)
    throw new Error('This page was made by another version. Make it again with "elastomorph landmarks".');
  const places = found.places.map((place) => ({
    ...place,
    camera: place.camera as Camera | null,
    key: `${place.kind}/${place.pose}/${place.name}`,
  }));
  return { ...found, places };
}

/** Marks on the places of the page, from the file. */
export function marksOf({ places, known }: Task): Marks {
  return Object.fromEntries(places.map((place) => [place.key, marksAt(place, known)]));
}

function marksAt(place: Place, known: LandmarkFile): Readonly<Record<string, Mark>> {
  if (place.kind === 'template')
    return mapped(known.vertices, (vertex) => ({ at: [], vertex }));
  const table = place.kind === 'photograph' ? known.photographs[place.pose] : known.points;
  return mapped(table?.[place.name] ?? {}, (at) => ({ at }));
}

/** The file: marks on the places of the page take the place of what was known of these. */
export function fileOf({ places, known }: Task, marks: Marks): LandmarkFile {
  let { vertices, points } = known;
  const photographs: Record<string, Table> = { ...known.photographs };
  for (const place of places) {
    const own = marks[place.key] ?? {};
    if (place.kind === 'template') {
      vertices = mapped(own, ({ vertex }) => vertex!);
    } else if (place.kind === 'scan') {
      points = withPlace(points, place.name, own);
    } else {
      photographs[place.pose] = withPlace(photographs[place.pose] ?? {}, place.name, own);
      if (Object.keys(photographs[place.pose]!).length === 0) delete photographs[place.pose];
    }
  }
  return { version: 1, vertices, photographs, points };
}

function withPlace(table: Table, name: string, own: Readonly<Record<string, Mark>>): Table {
  const { [name]: _, ...others } = table;
  if (Object.keys(own).length === 0) return others;
  return { ...others, [name]: mapped(own, ({ at }) => at) };
}

function mapped<A, B>(table: Readonly<Record<string, A>>, to: (value: A) => B): Record<string, B> {
  return Object.fromEntries(Object.entries(table).map(([name, value]) => [name, to(value)]));
}
