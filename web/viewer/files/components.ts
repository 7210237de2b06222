// Which vertices hang together by triangles.

/** (V,) the first vertex of the connected piece of each vertex. */
export function componentsOf(triangles: Uint32Array, seams: Uint32Array): Uint32Array {
  const parent = Uint32Array.from(seams);
  const root = (vertex: number) => {
    let v = vertex;
    while (parent[v] !== v) {
      parent[v] = parent[parent[v]!]!;
      v = parent[v]!;
    }
    return v;
  };
  for (let i = 0; i < triangles.length; i += 3) {
    for (const next of [triangles[i + 1]!, triangles[i + 2]!]) {
      const [a, b] = [root(triangles[i]!), root(next)];
      if (a !== b) parent[Math.max(a, b)] = Math.min(a, b);
    }
  }
  return parent.map((_, v) => root(v));
}
