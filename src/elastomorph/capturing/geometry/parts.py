"""The parts of a template: the skin, which photographs are compared with, and what goes along.

Eyes, teeth, lashes and the like are surfaces of their own. Photographs show little of them, and
what they show lies behind glass, lids and lips: they are carried by the skin around them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.capturing.geometry.similarity import fit_similarity
from elastomorph.errors import CaptureError
from elastomorph.model.geometry import component_of, sides_of

Points = NDArray[np.float64]

# Vertices of the skin that carry a part, or a single vertex of one that is open.
_AROUND, _BESIDE = 60, 8


@dataclass(frozen=True, eq=False)
class Parts:
    """A template at rest, taken apart.

    Attributes:
        rest: (V, 3) positions.
        skin: (S,) int64 vertices of the part that holds the landmarks.
        place: (V,) int64 of each vertex in ``skin``; -1 for those of other parts.
        triangles: (T, 3) int64 of the skin, indices into ``skin``.
        solid: vertices of each closed part, an eye or a tooth, and (N,) the vertices, as indices
            into ``skin``, that carry it.
        loose: (L,) all other vertices.
        beside: (L, K) what carries each of them, indices into ``skin``.
        shares: (L, K) how much, rows of sum 1.
    """

    rest: Points
    skin: NDArray[np.int64]
    place: NDArray[np.int64]
    triangles: NDArray[np.int64]
    solid: tuple[tuple[NDArray[np.int64], NDArray[np.int64]], ...]
    loose: NDArray[np.int64]
    beside: NDArray[np.int64]
    shares: Points

    @classmethod
    def of(cls, rest: Points, triangles: NDArray[np.integer], landmarks: ArrayLike) -> Parts:
        """The parts of (V, 3) vertices and (T, 3) triangles; the skin holds (K,) the landmarks.

        Raises:
            CaptureError: Most landmarks are not on one part.
        """
        from scipy.spatial import cKDTree

        triangles = np.asarray(triangles, dtype=np.int64)
        sides = sides_of(triangles)
        part = component_of(len(rest), sides)
        votes = np.bincount(part[np.asarray(landmarks, dtype=np.int64)], minlength=part.max() + 1)
        chosen = int(votes.argmax())
        skin = np.flatnonzero(part == chosen)
        if 2 * votes[chosen] <= votes.sum() or len(skin) < 3:
            raise CaptureError(
                f"the template's landmarks are spread over {np.count_nonzero(votes)} parts that "
                "hang together with nothing: most of them have to be on one, the skin of the face"
            )
        place = np.full(len(rest), -1)
        place[skin] = np.arange(len(skin))
        mine = place[triangles[part[triangles[:, 0]] == chosen]]
        tree = cKDTree(rest[skin])
        solid, loose = [], []
        for vertices in _others(part, chosen):
            if len(vertices) > 3 and _closed(sides[part[sides[:, 0]] == part[vertices[0]]]):
                middle = rest[vertices].mean(axis=0)
                around = np.atleast_1d(tree.query(middle, k=min(_AROUND, len(skin)))[1])
                solid.append((vertices, around.astype(np.int64)))
            else:
                loose.append(vertices)
        others: NDArray[np.int64] = np.concatenate([np.zeros(0, dtype=np.int64), *loose])
        far, beside = tree.query(rest[others], k=min(_BESIDE, len(skin)))
        # What lies on a vertex of the skin goes exactly with it.
        shares = 1 / np.maximum(far, 1e-9 * np.ptp(rest)) ** 2
        shares /= shares.sum(axis=1, keepdims=True)
        near = np.asarray(beside, dtype=np.int64)
        return cls(rest, skin, place, mine, tuple(solid), others, near, shares)

    def carried(self, skin: Points) -> Points:
        """(V, 3) all vertices, from (S, 3) those of the skin."""
        vertices = self.rest.copy()
        vertices[self.skin] = skin
        before = self.rest[self.skin]
        for mine, around in self.solid:
            # Closed parts keep shape and size: eyes are balls, and teeth are hard.
            move = fit_similarity(before[around], skin[around], rigid=True)
            vertices[mine] = move(self.rest[mine])
        moved = (skin - before)[self.beside]
        vertices[self.loose] += np.einsum("lk,lkj->lj", self.shares, moved)
        return vertices


def _others(part: NDArray[np.int32], chosen: int) -> list[NDArray[np.int64]]:
    """Vertices of each part but the chosen one."""
    order = np.argsort(part, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(part[order])) + 1)
    return [group for group in groups if part[group[0]] != chosen]


def _closed(sides: NDArray[np.int64]) -> bool:
    """Whether each edge of a part is between two triangles."""
    counts = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)[1]
    return len(counts) > 0 and bool((counts == 2).all())
