"""Where a scan's face is: what brings a scan into the place and size of the template.

Landmarks say it. Without them a scan is laid over what is expected, the pose before it or the
template, from several sides, and only an answer that no other comes near is believed.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.similarity import Similarity, fit_similarity
from elastomorph.capturing.scans.correspondence import ScanPoints
from elastomorph.errors import CaptureError

Points = NDArray[np.float64]

# Reach in parts of the extent and steps at each, to lay a scan over a face.
_NEARBY = ((0.06, 8), (0.03, 8), (0.012, 8), (0.006, 6), (0.003, 6))
_FAR = ((0.25, 8), (0.12, 8), (0.06, 8))
_FROM_FAR = ((0.1, 15), (0.06, 15), (0.03, 15), (0.015, 10), (0.008, 8))
# Points of a face, and of a scan, that guesses are made with, and of a face for the last.
_FEW, _COARSE, _ENOUGH = 600, 12_000, 4000
# A guess that moves by less than this part of the reach stays there, and the point that belongs
# to one of its vertices may be this part farther away than the nearest.
_AT_REST, _NEARLY = 0.05, 1.0
# From guesses that are near, few points and all; how far these are turned, in radians; and the
# noise of scans, in parts of the extent.
_CLOSE = ((0.05, 6), (0.025, 6), (0.012, 6), (0.006, 6))
_FINE = ((0.012, 6), (0.006, 6), (0.003, 8))
_NODS, _NOISE = 0.07, 0.003
# A vertex is covered where the scan is this part of the extent away and faces the same way.
_COVERED, _SAME = 0.02, 0.8
# Covered part of a face from which on it was found, and what others, turned otherwise, may cover
# beside it.
_FOUND, _OTHERS = 0.3, 0.75
# Guesses that are followed to the end.
_TRIED = 16
# Sizes that are tried, beside that at which scan and face are equally large.
_SIZES = (1.0, 0.75, 0.55)


@dataclass(frozen=True, eq=False)
class Laid:
    """A scan laid over a face.

    Attributes:
        similarity: brings the scan there.
        covered: part of the face's vertices that the scan covers.
        off: median distance of those, in parts of the extent.
        explained: part of what is still that the scan has within its noise.
    """

    similarity: Similarity
    covered: float
    off: float
    explained: float


def laid_over(
    face: Points,
    normals: Points,
    size: float,
    scan: ScanPoints,
    first: Similarity,
    *,
    rigid: bool,
    reaches: tuple[tuple[float, int], ...] = _NEARBY,
    few: bool = False,
    still: Points | None = None,
) -> Laid:
    """A scan laid over a face from a first guess, by points and planes (Chen and Medioni, 1991).

    What moved between the two is far off at the last steps and does not count there.

    Args:
        face: (N, 3) vertices that a scanner sees.
        normals: (N, 3) of them.
        size: extent of the face.
        scan: in its own units and axes.
        first: brings the scan near the face.
        rigid: whether the scale stays.
        reaches: parts of the extent, and how many steps at each.
        few: whether few vertices are enough, for a guess.
        still: (N,) how much each vertex tells where the head is; all alike unless given.
    """
    still = np.ones(len(face)) if still is None else still
    step = max(1, len(face) // (_FEW if few else _ENOUGH))
    points, facing, own = face[::step], normals[::step], still[::step]
    nearly, at_rest = (_NEARLY, _AT_REST) if few else (0.0, 0.0)
    # The face is moved, so that the scan is sorted once.
    back = first.inverse()
    unit = back.scale * size
    for reach, steps in reaches:
        for _ in range(steps):
            here, there = back(points), facing @ back.rotation.T
            found = scan.matches(here, there, turn=reach * unit, nearly=nearly)
            weights = own * found.weights(reach * unit)
            if np.count_nonzero(weights) < 10:
                break
            move = _step(here, found.points, found.normals, weights, rigid)
            back = back.then(move)
            unit = back.scale * size
            if np.abs(back(points) - here).max() < at_rest * reach * unit:
                break
    if few:
        face, normals, still = points, facing, own
    here, there = back(face), normals @ back.rotation.T
    found = scan.matches(here, there, turn=_COVERED * unit)
    near = (found.distances < _COVERED * unit) & (found.cosines > _SAME) & ~found.border
    off = float(np.median(found.distances[near]) / unit) if near.any() else np.inf
    explained = still @ found.weights(_NOISE * unit) / max(still.sum(), 1e-300)
    return Laid(back.inverse(), float(near.mean()), off, float(explained))


def found_near(
    face: Points,
    normals: Points,
    size: float,
    scan: ScanPoints,
    firsts: list[Similarity],
    still: Points,
) -> tuple[Laid, Similarity]:
    """A scan laid over a face from guesses and from such as are turned a little.

    What is still lies on the scan within its noise once the head is in its place. A place between
    that and one to which a jaw has dragged it has more of the face near, and less of it so close:
    of all ends the one counts that explains most.

    Args:
        face: (N, 3) vertices that a scanner sees.
        normals: (N, 3) of them.
        size: extent of the face.
        scan: in its own units and axes.
        firsts: guesses, which keep their scale.
        still: (N,) how much each vertex tells where the head is.

    Returns:
        How the scan lies, and what would bring it there were all of the face taken for still: where
        both agree it does not matter what has moved.
    """
    from scipy.spatial.transform import Rotation

    middle = np.average(face, axis=0, weights=still)
    tried = []
    for first in firsts:
        for turn in (np.zeros(3), *_NODS * np.vstack([np.eye(3), -np.eye(3)])):
            nod = np.asarray(Rotation.from_rotvec(turn).as_matrix())
            own = first.then(Similarity(1.0, nod, middle - nod @ middle))
            tried.append(
                laid_over(
                    *(face, normals, size, scan, own),
                    rigid=True,
                    reaches=_CLOSE,
                    few=True,
                    still=still,
                )
            )
    best = max(tried, key=lambda each: each.explained).similarity
    found = laid_over(face, normals, size, scan, best, rigid=True, reaches=_FINE, still=still)
    # Where nothing says what is still, what moved is told by how far it is off, and counts again
    # once that may be more.
    reaches = _FINE if np.ptp(still) else _FINE[:1]
    dragged = laid_over(face, normals, size, scan, found.similarity, rigid=True, reaches=reaches)
    return found, dragged.similarity


def found_anywhere(
    face: Points, normals: Points, size: float, scan: ScanPoints, scale: float | None
) -> Similarity:
    """A scan laid over a face without any guess.

    Args:
        face: (N, 3) vertices that a scanner sees.
        normals: (N, 3) of them.
        size: extent of the face.
        scan: in its own units and axes.
        scale: that brings the scan to the size of the face, if it is known.

    Raises:
        CaptureError: No way to lay it is clearly better than all others.
    """
    low, high = np.asarray(np.percentile(scan.points, [2, 98], axis=0))
    scan_middle, middle = (low + high) / 2, (face.min(axis=0) + face.max(axis=0)) / 2
    ratio = float(np.linalg.norm(np.ptp(face, axis=0)) / (np.linalg.norm(high - low) + 1e-300))
    coarse, tried, rigid = scan.fewer(_COARSE), [], scale is not None
    for factor in _SIZES if scale is None else (1.0,):
        own = ratio / factor if scale is None else scale
        for turn in _turns():
            first = Similarity(own, turn, middle - own * turn @ scan_middle)
            tried.append(
                laid_over(face, normals, size, coarse, first, rigid=rigid, reaches=_FAR, few=True)
            )
    tried.sort(key=lambda each: -each.covered)
    best = [
        laid_over(face, normals, size, coarse, own, rigid=rigid, reaches=_FROM_FAR, few=True)
        for own in _different(tried)
    ]
    best.sort(key=lambda each: -each.covered)
    others = [each.covered for each in best if _differ(each.similarity, best[0].similarity)]
    if best[0].covered < _FOUND or max(others, default=0.0) > _OTHERS * best[0].covered:
        raise CaptureError(
            "where the face is in it cannot be told without landmarks: name at least four points"
            " of it, as 'elastomorph landmarks' does"
        )
    return laid_over(face, normals, size, scan, best[0].similarity, rigid=rigid).similarity


def _step(
    here: Points, points: Points, normals: Points, weights: NDArray[np.float64], rigid: bool
) -> Similarity:
    """The small similarity that brings points nearest to planes, first order."""
    middle = (weights @ here) / weights.sum()
    size = float(np.sqrt(weights @ ((here - middle) ** 2).sum(axis=1) / weights.sum()))
    arms = (here - middle) / size
    root = np.sqrt(weights)[:, None]
    rows = [np.cross(arms, normals), normals]
    if not rigid:
        rows.append(np.einsum("ij,ij->i", arms, normals)[:, None])
    matrix = np.hstack(rows) * root
    right = np.einsum("ij,ij->i", points - here, normals)[:, None] * root / size
    # A little damping: a ball does not say how it is turned.
    square = matrix.T @ matrix + 1e-6 * weights.sum() * np.eye(matrix.shape[1])
    found = np.linalg.solve(square, matrix.T @ right)[:, 0]
    moved = arms + np.cross(found[:3], arms) + found[3:6]
    if not rigid:
        moved = moved + np.clip(found[6], -0.2, 0.2) * arms
    return fit_similarity(here, moved * size + middle, weights, rigid=rigid)


def _turns() -> list[Points]:
    """The 24 turns of a cube."""
    found = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            turn = np.eye(3)[list(order)] * np.array(signs)[:, None]
            if np.linalg.det(turn) > 0:
                found.append(turn)
    return found


def _different(tried: list[Laid]) -> list[Similarity]:
    """The best of those that differ, and of each turn the best of every size."""
    found: list[Similarity] = []
    for each in tried:
        own = each.similarity
        if all(
            _differ(own, other) or abs(np.log(own.scale / other.scale)) > 0.1 for other in found
        ):
            found.append(own)
    return found[:_TRIED]


def _differ(one: Similarity, other: Similarity) -> bool:
    """Whether two answers are turned otherwise, by more than 15 degrees."""
    cosine = (np.trace(one.rotation @ other.rotation.T) - 1) / 2
    return bool(cosine < np.cos(np.radians(15)))
