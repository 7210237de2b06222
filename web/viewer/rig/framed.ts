// What of a model fills the picture: its head, as far as it is drawn, and the neck it turns about.
import { Vector3 } from 'three';
import type { Model } from '../types/model';

const NECK = 0.25; // of the height of what is framed

/** (V,) 1 at what is drawn, and at what of it is framed; the box round that, and the neck. */
export function framedBox(model: Model) {
  const drawn = drawnVertices(model);
  const framed = framedVertices(model, drawn);
  const low = new Vector3(Infinity, Infinity, Infinity);
  const high = low.clone().negate();
  const at = new Vector3();
  framed.forEach((counts, v) => {
    if (!counts) return;
    at.fromArray(model.neutral, 3 * v);
    low.min(at);
    high.max(at);
  });
  const neck = new Vector3().addVectors(low, high).multiplyScalar(0.5);
  neck.y = low.y + NECK * (high.y - low.y);
  return { drawn, framed, low, high, neck };
}

/** (V,) 1 at the vertices of parts that are drawn. */
function drawnVertices({ neutral, parts, triangles }: Model): Uint8Array {
  const drawn = new Uint8Array(neutral.length / 3);
  for (const { start, count, shown } of parts) {
    if (shown) for (let i = start; i < start + count; i += 1) drawn[triangles[i]!] = 1;
  }
  return drawn;
}

/** Those of the head, where there is a body too. */
function framedVertices({ head }: Model, drawn: Uint8Array): Uint8Array {
  const framed = head ? drawn.map((counts, v) => counts & head[v]!) : drawn;
  return framed.some((counts) => counts) ? framed : drawn;
}
