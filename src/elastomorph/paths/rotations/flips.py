"""No polygon flips that the straight line does not flip: bends are eased where one would."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.morph import Morph
from elastomorph.model.polygons import Polygons, polygon_normals
from elastomorph.paths.rotations.vertex_rotations import Neighbourhoods

if TYPE_CHECKING:
    from scipy.sparse import csr_array

_TIMES = np.arange(1, 64) / 64
# Rounds of halving; what still flips after them goes straight, with a ring more each round.
ROUNDS = 12
# Rings over which an eased bend fades into the full bends around it.
_RINGS = 4
# What rounding may add to the bounds, as a part of them.
_ROUNDING = 1e-9


def without_flips(
    morph: Morph, around: Neighbourhoods, whole: Sequence[NDArray[np.int64]] = ()
) -> Morph:
    """The same path with smaller bends around polygons that flip in between.

    A polygon flips where its normal points against that of the neutral and that of the
    target, at a time at which it does not on the straight line. The bends of its vertices are
    halved, those of the rings around reduced less and less, and the polygons that this touches are
    looked at again, until none flips at any of 63 times. Where twelve rounds are not enough,
    vertices go straight. ``bake_error`` stays that of the path before. Parts that turn as a
    ``whole`` cannot flip; by half a turn their normals are at right angles to both ends halfway.
    """
    faces = morph.neutral.faces
    if not len(morph.bends) or not len(faces):
        return morph
    bent = (morph.bends != 0).any(axis=(0, 2))
    for part in whole:
        bent[part] = False
    check = _suspects(morph, _touching(faces, bent))
    share = np.ones(len(bent))
    rounds = 0
    while (flipped := _flipped(morph, check, share)).any():
        before = share.copy()
        if rounds < ROUNDS:
            share *= easing(flipped, around.adjacency)
        else:
            share[around.within(flipped, rounds - ROUNDS)] = 0.0
        rounds += 1
        # Easing moves neighbours apart: what was safe with full bends need not be safe now.
        check = _touching(faces, bent & (share != before))
    return replace(morph, bends=morph.bends * share[:, None]) if rounds else morph


def easing(flipped: NDArray[np.bool_], adjacency: csr_array) -> NDArray[np.float64]:
    """(V,) ½ at flipped vertices, rising to 1 over the rings around them."""
    reached = flipped.astype(np.float64)
    rings = reached.copy()
    for _ in range(_RINGS):
        reached = np.minimum(1.0, reached + adjacency @ reached)
        rings += reached
    # A vertex counts once for every ring radius that reaches it.
    return np.asarray(1.0 - 0.5 * rings / (_RINGS + 1))


def _touching(faces: Polygons, vertices: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(F,) polygons with one of the vertices."""
    return np.asarray(np.logical_or.reduceat(vertices[faces.indices], faces.offsets[:-1]))


@dataclass(frozen=True, eq=False)
class _Corners:
    """Some polygons of a morph with the N vertices they need, which are (N,) `vertices` of it."""

    faces: Polygons
    vertices: NDArray[np.int64]
    start: NDArray[np.float64]
    end: NDArray[np.float64]
    bends: NDArray[np.float64]

    @classmethod
    def of(cls, morph: Morph, chosen: NDArray[np.bool_]) -> _Corners:
        faces = morph.neutral.faces
        indices = faces.indices[chosen[faces.corner_faces]]
        used = np.zeros(len(morph.neutral.vertices), dtype=bool)
        used[indices] = True
        vertices = np.flatnonzero(used)
        offsets = np.concatenate([[0], np.cumsum(faces.sizes[chosen])])
        own = Polygons((np.cumsum(used) - 1)[indices], offsets)
        start, end = morph.neutral.vertices[vertices], morph.target.vertices[vertices]
        return cls(own, vertices, start, end, morph.bends[:, vertices])


def _suspects(morph: Morph, chosen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(F,) the polygons that could flip with the bends as they are; all others cannot.

    On the straight line n(t) = (1 - t)² n₀ + 2t(1 - t) m + t² n₁, and the bend adds to it at most
    ½ Σ_c (l_c r_{c+1} + r_c l_{c+1} + r_c r_{c+1}): l_c is the longer distance of corner c from the
    first corner at both ends, r_c how far the two can bend apart. A polygon is safe while n(t)·n₀
    is larger than that up to t = ½ and n(t)·n₁ from there on; Bernstein's coefficients of each half
    bound them from below.
    """
    suspects = chosen.copy()
    if not chosen.any():
        return suspects
    some = _Corners.of(morph, chosen)
    faces = some.faces
    first, half, last = (
        polygon_normals(points, faces)
        for points in (some.start, (some.start + some.end) / 2, some.end)
    )
    mixed = 2.0 * half - 0.5 * (first + last)
    corner, origin = faces.indices, faces.indices[faces.offsets[:-1]][faces.corner_faces]
    apart = reach(morph, some.bends[:, corner] - some.bends[:, origin])
    length = np.maximum(
        *(np.linalg.norm(p[corner] - p[origin], axis=1) for p in (some.start, some.end))
    )
    after = faces.next_corners
    terms = length * apart[after] + apart * length[after] + apart * apart[after]
    added = 0.5 * (1.0 + _ROUNDING) * np.add.reduceat(terms, faces.offsets[:-1])
    safe = np.ones(len(faces), dtype=bool)
    for own in (first, last):
        near, middle, far = (_dot(normals, own) for normals in (own, mixed, first + last - own))
        least = np.minimum(near, np.minimum(near + middle, (near + far) / 2 + middle) / 2)
        safe &= least >= added * np.sqrt(near)
    suspects[np.flatnonzero(chosen)[safe]] = False
    return suspects


def reach(morph: Morph, bends: NDArray[np.float64]) -> NDArray[np.float64]:
    """(C,) a bound of the length of Σ b_k(t) d_k over the 63 times, for (K, C, 3) vectors d_k.

    Bend curves are much alike; in their singular directions the sum of the lengths is a close one.
    """
    curves = np.stack([curve(_TIMES) for curve in morph.bend_curves], axis=1)
    left, singular, right = np.linalg.svd(curves, full_matrices=False)
    directions = np.tensordot(singular[:, None] * right, bends, axes=1)
    return np.asarray(np.abs(left).max(axis=0) @ np.linalg.norm(directions, axis=2))


def _flipped(
    morph: Morph, chosen: NDArray[np.bool_], share: NDArray[np.float64]
) -> NDArray[np.bool_]:
    """(V,) vertices of the chosen polygons that flip, bends scaled by (V,) shares."""
    vertices = np.zeros(len(share), dtype=bool)
    if not chosen.any():
        return vertices
    some = _Corners.of(morph, chosen)
    bends = some.bends * share[some.vertices, None]
    ends = polygon_normals(some.start, some.faces), polygon_normals(some.end, some.faces)
    over = np.zeros(len(some.faces), dtype=bool)
    for time in _TIMES:
        weights = [curve.at(float(time)) for curve in morph.bend_curves]
        straight = (1.0 - time) * some.start + time * some.end
        bent = straight + np.tensordot(weights, bends, axes=1)
        now = _against(polygon_normals(bent, some.faces), ends)
        if now.any():
            over |= now & ~_against(polygon_normals(straight, some.faces), ends)
    corners = some.faces.indices[over[some.faces.corner_faces]]
    vertices[some.vertices[corners]] = True
    return vertices


def _dot(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.einsum("fi,fi->f", first, second))


def _against(
    normals: NDArray[np.float64], ends: tuple[NDArray[np.float64], NDArray[np.float64]]
) -> NDArray[np.bool_]:
    return np.asarray((_dot(normals, ends[0]) < 0) & (_dot(normals, ends[1]) < 0))
