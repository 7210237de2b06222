"""Ease bends where a surface would pass deeper through itself than on the straight line.

Two vertices face each other, as on the lips of a mouth, where they are close, their normals are
opposed, and each is in front of the other. The depth of a vertex is how far it is behind the
closest point of the surface around the vertex that it faces, along the normal of that point. Depth
that the straight line has at the same time, or the neutral, or the target, is that of the shapes:
only what bends add to it counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.geometry import component_of, neighbours
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.surface import closest_weights
from elastomorph.paths.rotations.flips import ROUNDS, easing, reach, without_flips
from elastomorph.paths.rotations.vertex_rotations import Neighbourhoods

if TYPE_CHECKING:
    from scipy.sparse import csr_array

ALLOWED = 1e-3
"""How much deeper than straight a surface may pass through itself, as a fraction of D."""

_TIMES = np.arange(1, 6) / 6
# Vertices face each other within so many edges, and what faces one is among so many nearest.
_NEAR, _CANDIDATES = 4.0, 3
# Lips slide: the closest point is looked for in so many rings around the vertex that is faced. Lips
# bulge: vertices so many rings around those that face something are followed too.
_RINGS, _VERTEX_RINGS = 8, 3
# Vertices that stay farther apart than bends can bring them, and this many edges, do not pass.
_SLACK = 2.0
# A vertex that is not straight behind the closest point is beside the border of the surface.
_STRAIGHT_BEHIND = 0.9
# Rings around what is too deep that are eased as much.
_EASED_RINGS = 3
# Below, an excess is rounding, as a fraction of D.
_ROUNDING = 1e-6

Points = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Sheets:
    """The largest sheet of each connected part of a surface, found once for all targets.

    Triangles are of one sheet where they share a side with each other and no third. Lashes and
    tear films that are welded to a lid are sheets of their own: they lie on, and sweep through,
    what they grow from in any case.
    """

    numbers: Indices  # (V,) the sheet of each vertex, -1 without
    triangles: Indices  # (T, 3)
    ring: csr_array  # (V, V) ones where an edge of a sheet joins two vertices, and on the diagonal

    @classmethod
    def of(cls, neutral: Mesh, around: Neighbourhoods) -> Sheets:
        """Split a surface at the sides of more than two triangles."""
        from scipy.sparse import csr_array, diags_array, eye_array

        triangles = neutral.faces.triangles().astype(np.int64)
        total = len(neutral.vertices)
        sheet = component_of(len(triangles), neighbours(triangles))
        part = component_of(total, around.edges)[triangles[:, 0]]
        rising = np.argsort(np.bincount(sheet)[sheet], kind="stable")
        largest = np.zeros(total, dtype=np.int64)
        largest[part[rising]] = sheet[rising]
        kept = sheet == largest[part]
        numbers = np.full(total, -1, dtype=np.int64)
        numbers[triangles[kept]] = sheet[kept, None]
        within = diags_array((numbers >= 0).astype(np.float64), format="csr")
        ring = within @ (around.adjacency + eye_array(total, format="csr")) @ within
        return cls(numbers, triangles[kept], csr_array(ring))


def without_passing(
    morph: Morph, around: Neighbourhoods, sheets: Sheets, whole: Sequence[Indices], scale: float
) -> Morph:
    """The same path with smaller bends where a sheet would pass deeper through itself.

    As in `without_flips`, bends are halved where a vertex is `ALLOWED` deeper than straight, and
    less and less around it, until none is; polygons that turn over by that are eased too. Where
    the path has a choice, it tells what was eased and what is left. Depths are in parts of D, the
    ``scale``.
    """
    full, facing = morph.bends, _facing(morph, sheets, ALLOWED * scale)
    for rounds in count():
        deeper, crossing, deep = passing(morph, sheets, scale, facing)
        if not deep.any():
            break
        deep = around.within(deep, _EASED_RINGS)
        share = easing(deep, around.adjacency)
        if rounds >= ROUNDS:
            share[around.within(deep, rounds - ROUNDS)] = 0.0
        morph = without_flips(replace(morph, bends=morph.bends * share[:, None]), around, whole)
    if morph.choice is None:
        return morph
    eased = int((morph.bends != full).any(axis=(0, 2)).sum())
    choice = replace(morph.choice, eased=eased, crossing=crossing, deeper=deeper)
    return replace(morph, choice=choice)


def passing(
    morph: Morph, sheets: Sheets, scale: float, facing: tuple[Indices, Indices] | None = None
) -> tuple[float, int, NDArray[np.bool_]]:
    """The largest excess of depth / D, how many cross at most, and (V,) which are too deep."""
    from scipy.sparse import csr_array, eye_array

    deeper, crossing, deep = 0.0, 0, np.zeros(len(sheets.numbers), dtype=bool)
    vertices, faced = facing or _facing(morph, sheets, ALLOWED * scale)
    if not len(vertices):
        return deeper, crossing, deep
    patches = csr_array(eye_array(len(deep), format="csr"))[faced]
    for _ in range(_RINGS):
        patches = patches @ sheets.ring
    used = np.zeros(len(deep), dtype=bool)
    used[vertices] = used[patches.indices] = True
    # Only what is near is looked at, in numbers of its own.
    triangles = sheets.triangles[used[sheets.triangles].any(axis=1)]
    near, corner = np.unique(triangles, return_inverse=True)
    triangles, vertices = corner.reshape(-1, 3), np.searchsorted(near, vertices)
    patches, bends = patches[:, near], morph.bends[:, near]
    start, end = morph.neutral.vertices[near], morph.target.vertices[near]
    at_vertex = csr_array((np.ones(corner.size), (corner.ravel(), np.arange(corner.size) // 3)))

    def closest(points: Points, rows: Indices) -> tuple[Points, Points, Indices, Points]:
        """Depth, squared distance, (R, 3) corners of the triangle and weights of its corners."""
        vertex, around = vertices[rows], patches[rows]
        off = points[around.indices] - np.repeat(points[vertex], np.diff(around.indptr), axis=0)
        fans = at_vertex[around.indices[least_places(_square(off), around.indptr[:-1])]]
        vertex, corners = np.repeat(vertex, np.diff(fans.indptr)), triangles[fans.indices]
        shares = closest_weights(points[vertex], points[corners])
        depth, square = _behind(points, _normals(points, triangles), vertex, corners, shares)
        best = least_places(square, fans.indptr[:-1])
        return depth[best], square[best], corners[best], shares[best]

    for time in _TIMES:
        straight = (1.0 - time) * start + time * end
        points = straight + np.tensordot([c.at(float(time)) for c in morph.bend_curves], bends, 1)
        depth, square, corners, shares = closest(points, np.arange(len(vertices)))
        # The same points straight; only where they are less deep, what is closest there.
        normals = _normals(straight, triangles)
        before = np.maximum(_behind(straight, normals, vertices, corners, shares)[0], 0.0)
        more = (depth - before > _ROUNDING * scale) & (depth > _STRAIGHT_BEHIND * np.sqrt(square))
        rows = np.flatnonzero(more)
        if not len(rows):
            continue
        first, middle, last = (closest(shape, rows)[0] for shape in (start, straight, end))
        before = np.maximum.reduce([before[rows], first, middle, last])
        # What is behind at both ends is the other side of the same flesh.
        before[np.minimum(first, last) > ALLOWED * scale] = np.inf
        excess = np.maximum(depth[rows] - before, 0.0) / scale
        deeper = max(deeper, float(excess.max()))
        crossing = max(crossing, int(((before <= 0) & (excess > _ROUNDING)).sum()))
        over = rows[excess > ALLOWED]
        deep[near[vertices[over]]] = deep[near[corners[over]]] = True
    return deeper, crossing, deep


def _facing(morph: Morph, sheets: Sheets, least: float) -> tuple[Indices, Indices]:
    """(M,) vertices that may pass by a length, and what they or those beside them face."""
    from scipy.sparse import csr_array

    start, end, ring = morph.neutral.vertices, morph.target.vertices, sheets.ring
    none = np.zeros(0, dtype=np.int64)
    bent = np.flatnonzero(reach(morph, morph.bends) > least / 2) if len(morph.bends) else none
    bent = bent[sheets.numbers[bent] >= 0]
    if not len(bent):
        return none, none
    edges = start[ring[bent].indices] - np.repeat(start[bent], np.diff(ring[bent].indptr), axis=0)
    edge = float(np.sqrt(_square(edges)).sum()) / max(len(edges) - len(bent), 1)
    near, first, other = _NEAR * edge, [none], [none]
    for points in (start, (start + end) / 2, end):
        low, high = points[bent].min(axis=0) - near, points[bent].max(axis=0) + near
        inside = ((points >= low) & (points <= high)).all(axis=1) & (sheets.numbers >= 0)
        normals = _normals(points, sheets.triangles[inside[sheets.triangles].any(axis=1)])
        rows, found = facing(
            points, normals, sheets, np.flatnonzero(inside), bent, near, _CANDIDATES
        )
        first.append(rows)
        other.append(found)
    pair = np.concatenate(first + other), np.concatenate(other + first)
    pairs = csr_array((np.ones(len(pair[0])), pair), ring.shape)
    for _ in range(_VERTEX_RINGS):
        pairs = ring @ pairs
    vertices, faced = pairs.nonzero()
    if not len(vertices):
        return none, none
    begins = np.flatnonzero(np.diff(vertices, prepend=-1))
    closest = least_places(_square(start[vertices] - start[faced]), begins)
    vertices, faced = vertices[closest], faced[closest]
    apart = reach(morph, morph.bends[:, vertices] - morph.bends[:, faced])
    gap, change = ((shape[faced] - shape[vertices]) for shape in (start, end - start))
    gaps = np.sqrt([_square(gap + time * change) for time in (0.0, *_TIMES, 1.0)])
    kept = (apart > least) & (gaps.min(axis=0) < apart + _SLACK * edge)
    return vertices[kept], faced[kept]


def facing(
    points: Points,
    normals: Points,
    sheets: Sheets,
    some: Indices,
    asked: Indices,
    near: float,
    candidates: int,
) -> tuple[Indices, Indices]:
    """(N,) vertices of those asked for, and (N,) what each faces among the nearest of some.

    Each is in front of the other, on the same sheet and closer than a distance.
    """
    from scipy.spatial import cKDTree

    # Close in place and in normal, reversed, and of the same sheet: one distance for all.
    sheet = 2.0 * near * sheets.numbers[:, None]
    tree = cKDTree(np.hstack([points, near * normals, sheet])[some], balanced_tree=False)
    reversed_ = np.hstack([points, -near * normals, sheet])[asked]
    distance, close = tree.query(
        reversed_, k=[*range(1, candidates + 1)], distance_upper_bound=near
    )
    close = np.append(some, 0)[close]
    gap = points[close] - points[asked, None]
    front = np.isfinite(distance) & (np.einsum("bci,bi->bc", gap, normals[asked]) > 0)
    row, column = (front & (np.einsum("bci,bci->bc", gap, normals[close]) < 0)).nonzero()
    return asked[row], close[row, column]


def _behind(
    points: Points, normals: Points, vertex: Indices, corners: Indices, shares: Points
) -> tuple[Points, Points]:
    """(N,) how far vertices are behind points of triangles, and their squared distances."""
    normal = np.einsum("nc,nci->ni", shares, normals[corners])
    length = np.sqrt(_square(normal))
    off = np.einsum("nc,nci->ni", shares, points[corners]) - points[vertex]
    return np.einsum("ni,ni->n", off, normal) / np.where(length > 0, length, 1.0), _square(off)


def _normals(points: Points, triangles: Indices) -> Points:
    """(V, 3) unit normals of vertices, of triangles by their areas; zero where there are none."""
    a, b, c = points[triangles.T]
    across = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    sums = [np.bincount(triangles.ravel(), values, len(points)) for values in across.T]
    normals = np.stack(sums, axis=1)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.asarray(normals / np.where(length > 0, length, 1.0))


def _square(vectors: Points) -> Points:
    return np.asarray(np.einsum("ni,ni->n", vectors, vectors))


def least_places(values: Points, begins: NDArray[np.integer]) -> Indices:
    """(R,) the place of the least value of each row, the first of several."""
    sizes = np.diff(np.append(begins, len(values)))
    places = np.flatnonzero(values == np.repeat(np.minimum.reduceat(values, begins), sizes))
    return np.asarray(places[np.searchsorted(places, begins)])
