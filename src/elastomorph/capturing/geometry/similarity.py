"""Similarities: what brings the points of one frame into another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import CaptureError

Points = NDArray[np.float64]

# Triples of pairs that are tried to find the similarity that most pairs agree with.
_TRIALS = 3000


@dataclass(frozen=True, eq=False)
class Similarity:
    """x ↦ scale · rotation x + shift.

    Attributes:
        scale: larger than 0.
        rotation: (3, 3) orthogonal; of determinant −1 if it mirrors.
        shift: (3,) in the units of the goal.
    """

    scale: float
    rotation: Points
    shift: Points

    @classmethod
    def identity(cls) -> Similarity:
        """What changes nothing."""
        return cls(1.0, np.eye(3), np.zeros(3))

    def __call__(self, points: Points) -> Points:
        """(..., 3) points, moved."""
        return self.scale * points @ self.rotation.T + self.shift

    def inverse(self) -> Similarity:
        """What undoes it."""
        back = self.rotation.T
        return Similarity(1 / self.scale, back, -(back @ self.shift) / self.scale)

    def then(self, other: Similarity) -> Similarity:
        """This one first, the other after it."""
        return Similarity(
            self.scale * other.scale, other.rotation @ self.rotation, other(self.shift)
        )


def fit_similarity(
    source: Points,
    goal: Points,
    weights: NDArray[np.float64] | None = None,
    *,
    rigid: bool = False,
    mirrored: bool | None = False,
) -> Similarity:
    """The similarity of least weighted squares Σ w ‖s R a + t − b‖² (Umeyama, PAMI 13(4), 1991).

    Args:
        source: (N, 3) points a, at least three that are not on one line.
        goal: (N, 3) points b.
        weights: (N,) ≥ 0; all equal unless given.
        rigid: keep the scale at 1.
        mirrored: whether R is a reflection; None lets it be whichever fits better.

    Raises:
        CaptureError: fewer than three points, or all of them on one line.
    """
    w = np.ones(len(source)) if weights is None else weights
    if np.count_nonzero(w) < 3:
        raise CaptureError(f"a similarity needs at least 3 pairs of points, found {len(source)}")
    w = w / w.sum()
    a, b = w @ source, w @ goal
    left, values, right = np.linalg.svd((goal - b).T @ (w[:, None] * (source - a)))
    if values[1] <= 1e-12 * max(values[0], np.finfo(float).tiny):
        raise CaptureError("a similarity needs points that are not all on one line")
    sign = np.sign(np.linalg.det(left @ right))
    last = sign if mirrored is False else (-sign if mirrored else 1.0)
    signs = np.array([1.0, 1.0, last])
    rotation = (left * signs) @ right
    scale = 1.0 if rigid else float(values @ signs / (w @ ((source - a) ** 2).sum(axis=1)))
    return Similarity(scale, rotation, b - scale * rotation @ a)


def agreeing(
    source: Points,
    goal: Points,
    tolerance: float,
    *,
    rigid: bool = False,
) -> tuple[Similarity, NDArray[np.bool_]]:
    """The similarity that most pairs agree with (RANSAC), refitted to those.

    Args:
        source: (N, 3) points.
        goal: (N, 3) points; many pairs may be wrong.
        tolerance: distance at which a pair agrees, in the units of the goal.
        rigid: keep the scale at 1.

    Returns:
        The similarity and (N,) which pairs agree.

    Raises:
        CaptureError: fewer than three pairs agree with any similarity.
    """
    random = np.random.default_rng(0)
    best: NDArray[np.bool_] = np.zeros(len(source), dtype=bool)
    for _ in range(_TRIALS if len(source) >= 3 else 0):
        few = random.choice(len(source), 3, replace=False)
        try:
            found = fit_similarity(source[few], goal[few], rigid=rigid)
        except CaptureError:
            continue
        agree = _within(found, source, goal, tolerance)
        if np.count_nonzero(agree) > np.count_nonzero(best):
            best = agree
    for _ in range(5):
        found = fit_similarity(source[best], goal[best], rigid=rigid)
        again = _within(found, source, goal, tolerance)
        if (again == best).all():
            return found, best
        best = again
    return found, best


def robust_rigid(source: Points, goal: Points, reaches: tuple[float, ...]) -> Similarity:
    """The rigid motion that brings to their goals the points that move as one, others aside.

    Args:
        source: (N, 3) points.
        goal: (N, 3) where each is to be.
        reaches: distances at which a point counts a quarter, one after the other, from rough to
            fine (Geman and McClure's weights).

    Raises:
        CaptureError: fewer than three points count, or all of them are on one line.
    """
    found = Similarity.identity()
    for reach in reaches:
        for _ in range(5):
            off = np.linalg.norm(found(source) - goal, axis=1)
            found = fit_similarity(source, goal, 1 / (1 + (off / reach) ** 2) ** 2, rigid=True)
    return found


def _within(found: Similarity, source: Points, goal: Points, tolerance: float) -> NDArray[np.bool_]:
    distances: NDArray[np.float64] = np.linalg.norm(found(source) - goal, axis=1)
    return distances < tolerance
