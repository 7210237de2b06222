"""Points in space: how far they reach, what hangs together, and how they moved as one."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_BLOCK = 512


def largest_distance(points: NDArray[np.float64]) -> float:
    """The largest distance between two of (N, 3) points, N ≥ 1, exact up to rounding.

    Only corners of the convex hull can be farthest apart, so the hull is taken first, in the
    dimension that the points really span.
    """
    from scipy.spatial import ConvexHull, QhullError

    centred = points - points.mean(axis=0)
    singular, axes = np.linalg.svd(centred, full_matrices=False)[1:]
    rank = int((singular > 1e-12 * max(float(singular[0]), np.finfo(float).tiny)).sum())
    candidates = points
    if rank == 0:  # all of them coincide
        candidates = points[:1]
    elif rank == 1:
        along = centred @ axes[0]
        candidates = points[[int(along.argmin()), int(along.argmax())]]
    elif rank >= 2 and len(points) > 50:
        try:
            candidates = points[ConvexHull(centred @ axes[:rank].T).vertices]
        except QhullError:  # nearly degenerate: the exhaustive search is slower, never wrong
            candidates = points
    largest = 0.0
    for start in range(0, len(candidates), _BLOCK):
        offsets = candidates[start : start + _BLOCK, None] - candidates[None, start:]
        largest = max(largest, float(np.einsum("ijk,ijk->ij", offsets, offsets).max()))
    return float(np.sqrt(largest))


def moved_extent(neutral: NDArray[np.float64], targets: Iterable[NDArray[np.float64]]) -> float:
    """D of a rig: the largest distance between two vertices that a target moves, 0 without any.

    A body below the face, which no target moves, does not count: it would loosen every tolerance.
    Where a single vertex moves, which has no extent, D is that of the whole neutral.
    """
    moved = np.zeros(len(neutral), dtype=bool)
    for target in targets:
        moved |= (target != neutral).any(axis=1)
    return (largest_distance(neutral[moved]) or largest_distance(neutral)) if moved.any() else 0.0


def least_motion(neutral: NDArray[np.float64], targets: Iterable[NDArray[np.float64]]) -> float:
    """Half a percent of `moved_extent`: a vertex that a target moves less is carried along."""
    return 0.005 * moved_extent(neutral, targets)


def component_of(count: int, edges: NDArray[np.integer]) -> NDArray[np.int32]:
    """(V,) numbers from 0 of the connected components; edges may repeat, in any order."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    # Ones are added up where an edge repeats: in 8 bits 256 of them would make none.
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int32)


def sides_of(triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """(3 T, 2) vertices at the ends of the sides of (T, 3) triangles."""
    sides = [triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]
    return np.concatenate(sides).astype(np.int64)


def neighbours(triangles: NDArray[np.integer]) -> NDArray[np.int64]:
    """(P, 2) triangles on both sides of each side that two have, and no third, of (T, 3)."""
    sides = np.sort(sides_of(triangles), axis=1)
    _, side, uses = np.unique(
        sides @ [triangles.max(initial=0) + 1, 1], return_inverse=True, return_counts=True
    )
    two = np.flatnonzero(uses[side] == 2)
    pairs = two[np.argsort(side[two], kind="stable")].reshape(-1, 2)
    return np.asarray(pairs % max(len(triangles), 1))


def connected_parts(count: int, edges: NDArray[np.integer]) -> list[NDArray[np.int64]]:
    """Rising vertices of each connected component, in the order of their first vertices."""
    part_of = component_of(count, edges)
    order = np.argsort(part_of, kind="stable")
    starts = np.flatnonzero(np.diff(part_of[order], prepend=-1))
    return np.split(order.astype(np.int64), starts[1:])


@dataclass(frozen=True, eq=False)
class Screw:
    """A turn about an axis and a slide along it."""

    axis: NDArray[np.float64]  # (3,) unit vector
    angle: float  # Turn about the axis, radians from 0 to π
    centre: NDArray[np.float64]  # (3,) a point on the axis
    slide: float  # Distance moved along the axis

    def at(self, part: float, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 3) the points after a part of the motion: 0 none, 1 all of it."""
        arms = points - self.centre
        angle = part * self.angle
        across = arms - (arms @ self.axis)[:, None] * self.axis
        # Added to the points: of a small turn the axis is so far away that arms lose digits.
        turned = np.sin(angle) * np.cross(self.axis, arms) - 2 * np.sin(angle / 2) ** 2 * across
        return np.asarray(points + turned + part * self.slide * self.axis)


def fit_rigid(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    weights: NDArray[np.float64] | None = None,
) -> tuple[Screw, NDArray[np.float64]]:
    """The rigid motion of (N, 3) points nearest to a motion in least squares (Kabsch, Chasles).

    And (N,) the distance of each end point from where the screw leads. The points are not all on
    one line; `weights` are those of the squared distances, all alike by default.
    """
    rotation, offset = fit_rotation(start, end, weights)
    screw = _screw(rotation, offset, np.average(start, axis=0, weights=weights))
    return screw, np.linalg.norm(screw.at(1.0, start) - end, axis=1)


def fit_rotation(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    weights: NDArray[np.float64] | None = None,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The (3, 3) rotation and (3,) offset of x → rotation x + offset, as for `fit_rigid`."""
    shares = np.full(len(start), 1.0 / len(start)) if weights is None else weights / weights.sum()
    start_mean, end_mean = shares @ start, shares @ end
    arms = (start - start_mean).T * shares
    left, _, right = np.linalg.svd(arms @ (end - end_mean))
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    rotation = (left @ mirror @ right).T
    return rotation, end_mean - rotation @ start_mean


def _screw(
    rotation: NDArray[np.float64], offset: NDArray[np.float64], near: NDArray[np.float64]
) -> Screw:
    """The screw of x → rotation x + offset; its centre is the point of the axis nearest to one."""
    skew = (rotation - rotation.T) / 2.0
    sine_axis = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    cosine = (np.trace(rotation) - 1.0) / 2.0
    angle = float(np.arctan2(np.linalg.norm(sine_axis), cosine))
    moved = rotation @ near + offset - near
    if angle < 1e-9:
        slide = float(np.linalg.norm(moved))
        axis = moved / slide if slide > 0 else np.array([0.0, 0.0, 1.0])
        return Screw(axis, 0.0, near, slide)
    # At half a turn the antisymmetric part vanishes, the symmetric part keeps the axis.
    symmetric = (rotation + rotation.T) / 2.0 - cosine * np.eye(3)
    column = symmetric[:, int(np.argmax(np.diag(symmetric)))]
    axis = column / np.linalg.norm(column)
    if axis @ sine_axis < 0:
        axis = -axis
    slide = float(axis @ moved)
    across = moved - slide * axis
    # In the plane across the axis, (I - R) arm = across: half the chord, and its right angle.
    arm = across / 2.0 + np.cross(axis, across) / (2.0 * np.tan(angle / 2.0))
    return Screw(axis, angle, near + arm, slide)
