"""No fold that the straight line does not have: bends are eased where polygons would turn over."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from elastomorph.morph import Morph
from elastomorph.polygon_normals import polygon_normals
from elastomorph.polygons import Polygons

__all__ = ["without_folds"]

_FINE = tuple(step / 64 for step in range(1, 64))
# Denser at the ends: a polygon that is nearly flat there turns quickly.
_COARSE = (1 / 64, 1 / 32, 1 / 16, *(step / 8 for step in range(1, 8)), 15 / 16, 31 / 32, 63 / 64)
# A polygon is safe whose ends are within this cosine, and that is so of one at coarse times.
_DOUBTFUL = 0.5
_ROUNDS = 12
# Rings over which an eased bend fades into the full bends around it.
_RINGS = 4


def without_folds(
    morph: Morph, adjacency: csr_array, whole: Sequence[NDArray[np.int64]] = ()
) -> Morph:
    """The same path with smaller bends around polygons that turn over in between.

    A polygon turns over where its normal points against that of the neutral and that of the
    target, at a time at which it does not on the straight line. The bends of its vertices are
    halved, those of the rings around reduced less and less, until no polygon turns over at any of
    63 times or its bends are nearly gone. ``bake_error`` stays that of the path before.

    Args:
        morph: A path.
        adjacency: (V, V) ones between neighbours.
        whole: Vertices of parts that turn as a whole and so cannot fold; by half a turn, their
            normals are at right angles to both ends in between.
    """
    faces = morph.neutral.faces
    if not len(morph.bends) or not len(faces):
        return morph
    bent = (morph.bends != 0).any(axis=(0, 2))
    for part in whole:
        bent[part] = False
    touched = np.logical_or.reduceat(bent[faces.indices], faces.offsets[:-1])
    if not touched.any():
        return morph
    probe = _Probe.of(morph, touched)
    share = np.ones(len(bent))
    for _ in range(_ROUNDS):
        folded = probe.folded(share)
        if not folded.any():
            break
        share *= _easing(folded, adjacency)
    if share.min() == 1.0:
        return morph
    return replace(morph, bends=morph.bends * share[:, None])


def _easing(folded: NDArray[np.bool_], adjacency: csr_array) -> NDArray[np.float64]:
    """(V,) ½ at folded vertices, rising to 1 over the rings around them."""
    reached = folded.astype(np.float64)
    rings = reached.copy()
    for _ in range(_RINGS):
        reached = np.minimum(1.0, reached + adjacency @ reached)
        rings += reached
    # A vertex counts once for every ring radius that reaches it.
    return np.asarray(1.0 - 0.5 * rings / (_RINGS + 1))


@dataclass(frozen=True, eq=False)
class _Probe:
    """The polygons that could turn over, and how to tell which of them do."""

    morph: Morph
    faces: Polygons
    ends: tuple[NDArray[np.float64], NDArray[np.float64]]

    @classmethod
    def of(cls, morph: Morph, touched: NDArray[np.bool_]) -> _Probe:
        probe = cls._with(morph, _some(morph.neutral.faces, touched))
        least = _cosine(*probe.ends)
        for time in _COARSE:
            normals = polygon_normals(morph.at(time), probe.faces)
            least = np.minimum(least, np.maximum(*(_cosine(normals, e) for e in probe.ends)))
        return cls._with(morph, _some(probe.faces, least < _DOUBTFUL))

    @classmethod
    def _with(cls, morph: Morph, faces: Polygons) -> _Probe:
        start, end = morph.neutral.vertices, morph.target.vertices
        return cls(morph, faces, (polygon_normals(start, faces), polygon_normals(end, faces)))

    def folded(self, share: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(V,) vertices of polygons that turn over when bends are scaled by (V,) shares."""
        vertices = np.zeros(len(share), dtype=bool)
        if not len(self.faces):
            return vertices
        morph = self.morph
        over = np.zeros(len(self.faces), dtype=bool)
        for time in _FINE:
            weights = [curve.at(time) for curve in morph.bend_curves]
            bend = np.tensordot(weights, morph.bends, axes=1) * share[:, None]
            straight = morph.neutral.vertices + time * morph.delta
            now = _against(polygon_normals(straight + bend, self.faces), self.ends)
            if now.any():
                over |= now & ~_against(polygon_normals(straight, self.faces), self.ends)
        vertices[self.faces.indices[over[self.faces.corner_faces]]] = True
        return vertices


def _some(faces: Polygons, chosen: NDArray[np.bool_]) -> Polygons:
    sizes = np.concatenate([[0], np.cumsum(faces.sizes[chosen])])
    return Polygons(faces.indices[chosen[faces.corner_faces]], sizes)


def _cosine(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    """(F,) cosine between normals, 0 where one of them is missing."""
    lengths = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
    products = np.einsum("fi,fi->f", first, second)
    cosines = np.divide(products, lengths, out=np.zeros_like(lengths), where=lengths > 0)
    return np.asarray(cosines)


def _against(
    normals: NDArray[np.float64], ends: tuple[NDArray[np.float64], NDArray[np.float64]]
) -> NDArray[np.bool_]:
    against: NDArray[np.bool_] = np.ones(len(normals), dtype=bool)
    for end in ends:
        against &= np.einsum("fi,fi->f", normals, end) < 0
    return against
