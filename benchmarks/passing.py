"""How much deeper a rig's paths pass through their own surface than straight ones.

    python benchmarks/passing.py [RIG ...] [--method auto] [--least 0.0002] [--only mouthClose]

Each target of a rig alone, at five times; the built-in head and ICT FaceKit where none is named.
What faces a vertex across a gap, as one lip does the other, is close, of the same sheet of the
surface, and has the opposed normal. The depth of a vertex is how far it is behind the closest place
there, along the normal of that place. What is as deep at the same time on the straight line, in the
neutral or in the target is the shapes' own: only what the bends add counts. What is behind at both
ends, as are the two sides of a cheek, does not face it. Depths are in % of D; how far around a
vertex one looks decides them in part.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import elastomorph as em
from elastomorph.model.geometry import component_of, sides_of
from elastomorph.model.morph import Morph
from elastomorph.paths.rotations.vertex_rotations import Neighbourhoods

ALLOWED = 1e-3  # of D: what is called deep

_TIMES = np.arange(1, 6) / 6
# In lengths of edges: how far away may be what faces a vertex.
_NEAR = 4.0
# The closest of what faces a vertex, and the rings around them of which one place is the closest
# later: lips slide, and come out at the front. Vertices are in rings around those that are faced.
_FACED = 3
_RINGS = 8
_VERTEX_RINGS = 3
# The square of a depth is all of that of the distance, but where the closest place is at a border.
_ABREAST = 0.81
# Below, a depth is rounding, as a fraction of D.
_ROUNDING = 1e-6

Points = NDArray[np.float64]
Indices = NDArray[np.int64]


def deeper(morph: Morph, around: Neighbourhoods, scale: float) -> tuple[float, int, int]:
    """How much deeper at most, as a fraction of D; vertices that cross, and that are deep."""
    facing = _Facing.of(morph, around, ALLOWED * scale)
    if facing is None:
        return 0.0, 0, 0
    most, crossing, deep = facing.measured(morph, scale)
    return most, crossing, int(deep.sum())


def reach(morph: Morph, bends: Points) -> Points:
    """(C,) a bound of the length of Σ b_k(t) d_k, for (K, C, 3) vectors d_k."""
    heights = np.array([curve.height for curve in morph.bend_curves])
    return np.asarray(heights @ np.linalg.norm(bends, axis=2))


@dataclass(frozen=True, eq=False)
class _Facing:
    """M vertices with what each of them faces, among the N that both and all around them are.

    Kept are (N,) `vertices` of the morph, (T, 3) triangles between them, those at each of them
    (`at_vertex` from `begins` on), and (P,) pairs: row of M, vertex and what it may be behind.
    """

    vertices: Indices
    triangles: Indices
    begins: Indices
    at_vertex: Indices
    row: Indices
    first: Indices
    other: Indices

    @classmethod
    def of(cls, morph: Morph, around: Neighbourhoods, least: float) -> _Facing | None:
        """What faces each other and may pass by more than a length; none where nothing can."""
        from scipy.sparse import csr_array, eye_array

        triangles = morph.neutral.faces.triangles().astype(np.int64)
        count = len(morph.neutral.vertices)
        if not len(morph.bends) or not len(triangles):
            return None
        bent = np.flatnonzero(reach(morph, morph.bends) > least / 2)
        first, other = _faced(morph, around, triangles, bent, least)
        part = _sheets(triangles, count)
        kept = part[first] == part[other]
        first, other = first[kept], other[kept]
        if not len(first):
            return None
        shape = (count, count)
        rows = np.concatenate([first, other]), np.concatenate([other, first])
        pairs = csr_array((np.ones(2 * len(first)), rows), shape=shape)
        ring = csr_array(around.adjacency + eye_array(count, format="csr"))
        for _ in range(_VERTEX_RINGS):
            pairs = ring @ pairs
        for _ in range(_RINGS):
            pairs = pairs @ ring
        first, other = (side.astype(np.int64) for side in pairs.nonzero())
        used = np.zeros(count, dtype=bool)
        used[first] = used[other] = True
        triangles = triangles[used[triangles].any(axis=1)]
        used[triangles] = True
        number = np.cumsum(used) - 1
        corners = number[triangles]
        order = np.argsort(corners, axis=None, kind="stable")
        begins = np.searchsorted(corners.ravel()[order], np.arange(number[-1] + 2))
        row = np.unique(first, return_inverse=True)[1]
        return cls(
            np.flatnonzero(used), corners, begins, order // 3, row, number[first], number[other]
        )

    def measured(self, morph: Morph, scale: float) -> tuple[float, int, NDArray[np.bool_]]:
        """The largest excess of depth / D, how many cross, and (V,) which are too deep."""
        start, end = (mesh.vertices[self.vertices] for mesh in (morph.neutral, morph.target))
        bends = morph.bends[:, self.vertices]
        deeper, crossing = 0.0, 0
        deep = np.zeros(len(morph.neutral.vertices), dtype=bool)
        rows = np.arange(self.row[-1] + 1)
        for time in _TIMES:
            straight = (1.0 - time) * start + time * end
            weights = [curve.at(float(time)) for curve in morph.bend_curves]
            points = straight + np.tensordot(weights, bends, axes=1)
            depth, square, vertex, corners, shares = self._depth(points, rows)
            # The same places straight; only where they are less deep, what is closest there.
            before = _behind(straight, self._normals(straight), vertex, corners, shares)[0]
            more = depth - np.maximum(before, 0.0) > _ROUNDING * scale
            # Beside the border of what is faced, there is no front and no back.
            more &= depth**2 > _ABREAST * square
            if not more.any():
                continue
            at_start, at_straight, at_end = (
                self._depth(shape, rows[more])[0] for shape in (start, straight, end)
            )
            depth, vertex, corners = depth[more], vertex[more], corners[more]
            before = np.maximum.reduce([before[more], at_start, at_straight, at_end])
            # What is behind at both ends is the other side of the same flesh.
            before[np.minimum(at_start, at_end) > ALLOWED * scale] = np.inf
            excess = np.maximum(depth - np.maximum(before, 0.0), 0.0) / scale
            deeper = max(deeper, float(excess.max()))
            crossing = max(crossing, int(((before <= 0) & (excess > _ROUNDING)).sum()))
            over = excess > ALLOWED
            deep[self.vertices[vertex[over]]] = True
            deep[self.vertices[corners[over]]] = True
        return deeper, crossing, deep

    def _normals(self, points: Points) -> Points:
        return _normals(points, self.triangles)

    def _depth(
        self, points: Points, rows: Indices
    ) -> tuple[Points, Points, Indices, Indices, Points]:
        """Of (M,) rows how deep they are behind the closest place that is faced.

        Also (M,) its squared distance, the vertices, and (M, 3) the corners around that place and
        their shares in it.
        """
        size = np.diff(np.searchsorted(self.row, np.arange(self.row[-1] + 2)))
        kept = slice(None) if len(rows) == len(size) else np.isin(self.row, rows)
        first, other = self.first[kept], self.other[kept]
        apart = points[first] - points[other]
        closest = _least(np.einsum("pi,pi->p", apart, apart), size[rows])
        vertex, other = first[closest], other[closest]
        size = self.begins[other + 1] - self.begins[other]
        row = np.repeat(np.arange(len(other)), size)
        place = np.arange(len(row)) + np.repeat(self.begins[other] - np.cumsum(size) + size, size)
        corners = self.triangles[self.at_vertex[place]]
        shares = _closest_shares(points[vertex[row]], points[corners])
        normals = self._normals(points)
        depth, square = _behind(points, normals, vertex[row], corners, shares)
        best = _least(square, size)
        return depth[best], square[best], vertex, corners[best], shares[best]


def _behind(
    points: Points, normals: Points, vertex: Indices, corners: Indices, shares: Points
) -> tuple[Points, Points]:
    """(N,) how far vertices are behind places of triangles, and their squared distances."""
    normal = np.einsum("nc,nci->ni", shares, normals[corners])
    length = np.linalg.norm(normal, axis=1)
    off = np.einsum("nc,nci->ni", shares, points[corners]) - points[vertex]
    behind = np.einsum("ni,ni->n", off, normal) / np.where(length > 0, length, 1.0)
    return behind, np.einsum("ni,ni->n", off, off)


def _faced(
    morph: Morph, around: Neighbourhoods, triangles: Indices, bent: Indices, least: float
) -> tuple[Indices, Indices]:
    """(P,) vertices, and others that they face at one of three times and may touch."""
    from scipy.spatial import cKDTree

    start, end = morph.neutral.vertices, morph.target.vertices
    none = np.zeros(0, np.int64)
    if not len(bent):
        return none, none
    first, second = start[around.edges.T]
    at_bent = np.zeros(len(start), dtype=bool)
    at_bent[bent] = True
    at_bent = at_bent[around.edges].any(axis=1)
    edge = float(np.linalg.norm((first - second)[at_bent], axis=1).mean())
    near, firsts, others = _NEAR * edge, [none], [none]
    for points in (start, (start + end) / 2, end):
        low, high = points[bent].min(axis=0) - near, points[bent].max(axis=0) + near
        inside = ((points >= low) & (points <= high)).all(axis=1)
        some = np.flatnonzero(inside)
        chosen = triangles[inside[triangles].any(axis=1)]
        normals = _normals(points, chosen)
        # One distance of places and normals: those of what is faced are opposed.
        tree = cKDTree(np.hstack([points, near * normals])[some], balanced_tree=False)
        opposed = np.hstack([points, -near * normals])[bent]
        found = tree.query(opposed, k=_FACED, distance_upper_bound=near)[1]
        v, w = np.repeat(bent, _FACED), np.append(some, -1)[found].ravel()
        gap = points[w] - points[v]
        seen = (w >= 0) & (np.einsum("pi,pi->p", gap, normals[v]) > 0)
        seen &= np.einsum("pi,pi->p", gap, normals[w]) < 0
        firsts.append(v[seen])
        others.append(w[seen])
    v, w = np.concatenate(firsts), np.concatenate(others)
    apart = reach(morph, morph.bends[:, v] - morph.bends[:, w])
    gap, later = start[w] - start[v], end[w] - end[v]
    change = later - gap
    square = np.einsum("pi,pi->p", change, change)
    time = -np.einsum("pi,pi->p", gap, change) / np.where(square > 0, square, 1.0)
    closest = np.linalg.norm(gap + np.clip(time, 0.0, 1.0)[:, None] * change, axis=1)
    kept = (apart > least) & (closest < apart + 2.0 * edge)
    return v[kept], w[kept]


def _sheets(triangles: Indices, count: int) -> Indices:
    """(V,) which sheet each vertex is of, the largest where several meet.

    Triangles are of one sheet where they share a side with each other and no third: lashes and
    films that are welded to lids are sheets of their own.
    """
    sides = np.sort(sides_of(triangles), axis=1)
    order = np.lexsort(sides.T)
    owner = order % len(triangles)
    new = np.append(True, (np.diff(sides[order], axis=0) != 0).any(axis=1))
    begins = np.flatnonzero(new)
    two = begins[np.diff(np.append(begins, len(order))) == 2]
    sheet = component_of(len(triangles), np.column_stack([owner[two], owner[two + 1]]))
    size = np.bincount(sheet)[sheet]
    found = np.full(count, -1, dtype=np.int64)
    smallest_first = np.argsort(size, kind="stable")
    found[triangles[smallest_first]] = sheet[smallest_first, None]
    return found


def _normals(points: Points, triangles: Indices) -> Points:
    """(V, 3) unit normals of vertices, those of triangles by their areas; zero where none is."""
    a, b, c = points[triangles.T]
    across = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    corners = triangles.ravel()
    sums = [np.bincount(corners, own, len(points)) for own in across.T]
    normals = np.stack(sums, axis=1)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(length > 0, length, 1.0))


def _least(values: Points, size: Indices) -> Indices:
    """(R,) the place of the least value of each row of so many, the first of several."""
    begins = np.cumsum(size) - size
    least = np.repeat(np.minimum.reduceat(values, begins), size)
    places = np.flatnonzero(values == least)
    return np.asarray(places[np.searchsorted(places, begins)])


def _closest_shares(points: Points, corners: Points) -> Points:
    """(N, 3) barycentric coordinates of the place on (N, 3, 3) triangles closest to (N, 3)."""
    a, b, c = corners.transpose(1, 0, 2)
    ab, ac, ap = b - a, c - a, points - a
    first, second, cross, p, q = (
        np.einsum("ni,ni->n", *two) for two in ((ab, ab), (ac, ac), (ab, ac), (ab, ap), (ac, ap))
    )
    area = first * second - cross * cross
    flat = area <= 0
    area[flat] = 1.0
    u, v = (second * p - cross * q) / area, (first * q - cross * p) / area
    best = np.stack([1.0 - u - v, u, v], axis=1)
    outside = np.flatnonzero(flat | (best.min(axis=1) < 0))
    least = np.full(len(outside), np.inf)
    for side in range(3):
        start, stop = corners[outside, side], corners[outside, (side + 1) % 3]
        along, off = stop - start, points[outside] - start
        square = np.einsum("ni,ni->n", along, along)
        part = np.einsum("ni,ni->n", along, off) / np.where(square > 0, square, 1.0)
        part = np.clip(part, 0.0, 1.0)
        square = ((off - part[:, None] * along) ** 2).sum(axis=1)
        closer = square < least
        least[closer] = square[closer]
        shares = np.zeros((len(outside), 3))
        shares[:, side], shares[:, (side + 1) % 3] = 1.0 - part, part
        best[outside[closer]] = shares[closer]
    return best


def main() -> None:
    """Print a row for each target whose path passes deeper than --least."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    ict = Path(os.environ.get("ELASTOMORPH_DATA", "data")) / "ict-facekit"
    parser.add_argument("rigs", nargs="*", default=["built-in", *([ict] if ict.is_dir() else [])])
    parser.add_argument("--method", default="auto")
    parser.add_argument("--least", type=float, default=2e-4, help="fraction of D")
    parser.add_argument("--only", help="a target")
    chosen = parser.parse_args()
    print("| rig | target | deeper, % of D | crossing | deeper than 0.1 % |\n|---|---|---|---|---|")
    for path in chosen.rigs:
        rig = em.read_rig(path, method=chosen.method)
        neutral = rig.neutral
        around = Neighbourhoods.of(len(neutral.vertices), neutral.edges)
        for name, morph in rig.morphs.items():
            if chosen.only not in (None, name):
                continue
            most, crossing, deep = deeper(morph, around, neutral.diameter)
            if most >= chosen.least:
                row = f"`{name}` | {100 * most:.3f} | {crossing} | {deep}"
                print(f"| {Path(path).name} | {row} |", flush=True)


if __name__ == "__main__":
    main()
