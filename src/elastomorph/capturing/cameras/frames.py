"""Poses brought into the frame of the neutral, by the part of the head that does not move.

Each pose is solved in a frame and a unit of its own. Points of two poses that look the same are
paired; a similarity is what most pairs agree on, among those of the forehead, the temples and the
upper nose where these are known, for cheeks, lips and jaw move and a neck turns. It is then fitted
again to pairs weighted by how well they agree (Tukey's biweight), with a width from the pairs
themselves: w = (1 - (r/c)²)² within c = 4.7 times the spread of r, none beyond. Skin that moves by
less than points are off, a brow beside a forehead, is told by those around it that move alike: a
pair has a second such weight, by the median of what it and its neighbours are off.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from elastomorph.capturing.cameras.models import SolvedPose
from elastomorph.capturing.geometry import Similarity, agreeing, fit_similarity
from elastomorph.errors import CaptureError

_RATIO = 0.85
_AGREES = 0.001  # of the size of the cloud
_STILL_NEAR = 0.015  # of the size of the template
_FEWEST_STILL, _FEWEST = 20, 12
_LEAST_SHARE = 0.08
_WIDTH, _ROUNDS = 4.685, 20
_AROUND = 16  # pairs that are looked at together
_SCALES_APART = 4.0
_CHUNK = 2000


@dataclass(frozen=True, eq=False)
class Frame:
    """How a pose comes into the neutral's frame.

    Attributes:
        similarity: From the pose's frame into the neutral's.
        pairs: (M, 2) points of the neutral and of the pose that look the same.
        agreeing: (M,) which of them it was fitted to.
        rms: Root mean square distance of those, in the neutral's unit.
    """

    similarity: Similarity
    pairs: NDArray[np.int64]
    agreeing: NDArray[np.bool_]
    rms: float


def paired(one: NDArray[np.float32], other: NDArray[np.float32]) -> NDArray[np.int64]:
    """Which of (N, K) and (M, K) unit descriptors are each other's nearest and distinct, (P, 2)."""
    if len(one) < 2 or len(other) < 2:
        return np.zeros((0, 2), dtype=np.int64)
    there, good_there = _nearest(one, other)
    back, good_back = _nearest(other, one)
    rows = np.arange(len(one))
    both = (back[there] == rows) & good_there & good_back[there]
    return np.stack([rows[both], there[both]], axis=1)


def brought(
    neutral: SolvedPose,
    pose: SolvedPose,
    name: str,
    *,
    still: NDArray[np.bool_] | None = None,
    rigid: bool = False,
) -> Frame:
    """The similarity that brings a pose into the neutral's frame.

    Args:
        neutral: Solved.
        pose: Solved.
        name: Of the pose, for messages.
        still: (N,) which of the neutral's points belong to the part of the head that does not
            move; without it that is what most pairs agree on, shoulders included.
        rigid: Both have the same unit, as with a rig of cameras that stayed where they were.

    Raises:
        CaptureError: The two do not show the same head.
    """
    pairs = paired(neutral.descriptors, pose.descriptors)
    size = cloud_size(neutral.points)
    which = np.arange(len(pairs))
    if still is not None:
        on_still = np.flatnonzero(still[pairs[:, 0]])
        which = on_still if len(on_still) >= _FEWEST_STILL else which
    source, goal = pose.points[pairs[which, 1]], neutral.points[pairs[which, 0]]
    try:
        found, agree = agreeing(source, goal, _AGREES * size, rigid=rigid)
    except CaptureError:
        agree = np.zeros(len(which), dtype=bool)
    if np.count_nonzero(agree) < max(_FEWEST, _LEAST_SHARE * len(which)):
        raise CaptureError(_no_match(name, len(pairs), int(np.count_nonzero(agree))))
    found, weights = _fitted(source, goal, found, _AGREES * size, rigid=rigid)
    sizes = found.scale * cloud_size(pose.points) / size
    if not 1 / _SCALES_APART < sizes < _SCALES_APART:
        raise CaptureError(_no_match(name, len(pairs), int(np.count_nonzero(agree))))
    used = np.zeros(len(pairs), dtype=bool)
    used[which[weights > 0]] = True
    off = np.linalg.norm(found(source) - goal, axis=1)[weights > 0]
    return Frame(found, pairs, used, float(np.sqrt(np.mean(off**2))))


def still_vertices(
    vertices: NDArray[np.float64], landmarks: Mapping[str, int]
) -> NDArray[np.bool_]:
    """Which vertices of a template lie above the tip of the nose, the face held upright, (V,).

    Args:
        vertices: (V, 3) of the template.
        landmarks: Its vertices of "nose_tip", and of eyes and mouth to tell up from down.

    Raises:
        CaptureError: Those landmarks are not there.
    """

    def middle(*names: str) -> NDArray[np.float64] | None:
        found = [vertices[landmarks[name]] for name in names if name in landmarks]
        return np.mean(found, axis=0) if found else None

    eyes = middle("right_eye_outer", "right_eye_inner", "left_eye_inner", "left_eye_outer")
    mouth = middle("mouth_right", "mouth_left", "upper_lip", "lower_lip", "chin")
    nose = middle("nose_tip")
    if eyes is None or mouth is None or nose is None:
        raise CaptureError(
            "the template lacks landmarks of nose, eyes or mouth; place them with "
            "'elastomorph landmarks'"
        )
    return np.asarray((vertices - nose) @ (eyes - mouth) > 0)


def near_still(
    points: NDArray[np.float64], vertices: NDArray[np.float64], still: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Which of (N, 3) points lie on the still part of a neutral surface.

    Args:
        points: Of the neutral's cloud.
        vertices: (V, 3) of the surface, in the frame and unit of the points.
        still: (V,) by `still_vertices`.
    """
    reach = _STILL_NEAR * float(np.linalg.norm(np.ptp(vertices, axis=0)))
    distances, nearest = cKDTree(vertices).query(points, distance_upper_bound=reach)
    # Where no vertex is near the tree counts one beyond the last.
    return np.asarray(np.isfinite(distances) & np.append(still, False)[nearest])


def cloud_size(points: NDArray[np.float64]) -> float:
    """Extent of a cloud without its farthest tenth, in its unit."""
    away = np.linalg.norm(points - np.median(points, axis=0), axis=1)
    return 2.0 * float(np.percentile(away, 90)) if len(points) else 0.0


def _nearest(
    one: NDArray[np.float32], other: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Of each descriptor the nearest other one, and whether it is distinct from the second."""
    found = np.zeros(len(one), dtype=np.int64)
    good = np.zeros(len(one), dtype=bool)
    for start in range(0, len(one), _CHUNK):
        part = slice(start, start + _CHUNK)
        alike = one[part] @ other.T
        rows = np.arange(len(alike))
        best = alike.argmax(axis=1)
        nearest = np.sqrt(np.maximum(2.0 - 2.0 * alike[rows, best], 0.0))
        alike[rows, best] = -1.0
        second = np.sqrt(np.maximum(2.0 - 2.0 * alike.max(axis=1), 0.0))
        found[part], good[part] = best, nearest < _RATIO * second
    return found, good


def _fitted(
    source: NDArray[np.float64],
    goal: NDArray[np.float64],
    found: Similarity,
    widest: float,
    *,
    rigid: bool,
) -> tuple[Similarity, NDArray[np.float64]]:
    """The similarity fitted again and again, and the weights (N,) of the pairs in the last."""
    weights = np.ones(len(source))
    near = cKDTree(goal).query(goal, k=min(_AROUND, len(goal)))[1]
    for _ in range(_ROUNDS):
        off = found(source) - goal
        weights = _biweight(off, widest) * _biweight(np.median(off[near], axis=1), widest)
        found = fit_similarity(source, goal, weights, rigid=rigid)
    return found, weights


def _biweight(off: NDArray[np.float64], widest: float) -> NDArray[np.float64]:
    """(N,) Tukey's weights of (N, 3) distances, none beyond `widest`."""
    far = np.linalg.norm(off, axis=1)
    # Of a distance in space with normal errors the median is 1.54 times their spread.
    spread = float(np.median(far[far < widest])) / 1.54
    width = min(_WIDTH * max(spread, 1e-12 * widest), widest)
    found: NDArray[np.float64] = (1.0 - np.minimum(far / width, 1.0) ** 2) ** 2
    return found


def _no_match(name: str, pairs: int, agree: int) -> str:
    return (
        f"pose '{name}': its head does not match the neutral's ({agree} of {pairs} places that "
        "look alike agree); photograph the same person with the same make-up and light, and the "
        "head turned alike"
    )
