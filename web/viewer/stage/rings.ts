// The corners of the triangles round each vertex; copies of one vertex at a seam share theirs.
import type { Model } from '../types/model';

export interface Rings {
  /** (V, 2) number of the first corner of each vertex, and how many there are. */
  readonly ofVertex: Uint32Array;
  /** (C, 2) the vertex after and before each corner. */
  readonly corners: Uint32Array;
}

export function ringsOf({ triangles, seams }: Model): Rings {
  const counts = new Uint32Array(seams.length);
  for (const vertex of triangles) counts[seams[vertex]!]! += 1;
  const starts = new Uint32Array(seams.length);
  for (let v = 1; v < starts.length; v += 1) starts[v] = starts[v - 1]! + counts[v - 1]!;
  const places = starts.slice();
  const corners = new Uint32Array(2 * triangles.length);
  for (let i = 0; i < triangles.length; i += 3) {
    for (let c = 0; c < 3; c += 1) {
      const place = places[seams[triangles[i + c]!]!]!++;
      corners[2 * place] = triangles[i + ((c + 1) % 3)]!;
      corners[2 * place + 1] = triangles[i + ((c + 2) % 3)]!;
    }
  }
  const ofVertex = new Uint32Array(2 * seams.length);
  for (let v = 0; v < seams.length; v += 1) {
    ofVertex[2 * v] = starts[seams[v]!]!;
    ofVertex[2 * v + 1] = counts[seams[v]!]!;
  }
  return { ofVertex, corners };
}
