"""Brings a scan to the place and size of the template, and cuts away what is around its face.

Landmarks say where the face is. Without them a scan is laid over what is expected, the pose before
it or the template, from several sides, and only an answer that no other comes near is believed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import permutations, product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry import Similarity, Surface, fit_similarity
from elastomorph.capturing.landmarks import fit_landmarks
from elastomorph.capturing.scans.correspondence import ScanPoints
from elastomorph.capturing.scans.expressions import Expressions
from elastomorph.capturing.scans.nonrigid import Elastic, Held
from elastomorph.capturing.scans.scans import Scan, require_one_head
from elastomorph.errors import CaptureError

Points = NDArray[np.float64]
Clicks = Mapping[str, tuple[float, float, float]]

# What no expression moves: by these the head is found in later poses.
_STILL = (
    *("right_eye_outer", "right_eye_inner", "left_eye_inner", "left_eye_outer", "nose_bridge"),
    *("nose_tip", "right_nostril", "left_nostril"),
)
# A vertex that some target moves by this part of the extent says a quarter as much of the head.
_MOVED = 0.005
# A scan is of the template's own shape that covers this part of it and is this near.
_SHAPED, _SAME_SHAPE = 0.3, 0.0025
# Landmarks that say less than this beside such a surface are left to it.
_UNSURE = 0.02
# The place of a head is off by this part of the way by which what moves would drag it.
_DOUBT = 0.5
# Points by which a scan is looked up, before its size is known.
_LOOKED_UP = 60_000
# How much of a face a scan must cover where it was expected, and how near it must be.
_EXPECTED, _NEAR = 0.5, 0.01
# Sizes of scans of one head differ by no more than this, unless their units do.
_SAME_SIZE = 1.12
# What is kept around a face, in parts of its box.
_AROUND = 0.2
# Of a mirrored scan, the distance that is left is this much smaller once it is mirrored back.
_MIRRORED = 0.75
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
class Marks:
    """Landmarks of a face and of scans.

    Attributes:
        vertices: landmark → vertex of the face without seams.
        points: scan → landmark → (x, y, z).
        where: they were read, for messages.
    """

    vertices: Mapping[str, int]
    points: Mapping[str, Clicks]
    where: str

    def on(self, scan: str) -> Clicks:
        """Those of a scan, which stand under the name of its file, with suffix or without."""
        names = (scan, Path(scan).name, Path(scan).stem)
        found: Clicks = next((self.points[own] for own in names if own in self.points), {})
        return {name: place for name, place in found.items() if name in self.vertices}


@dataclass(frozen=True, eq=False)
class Placed:
    """A scan in the place and size of the template.

    Attributes:
        scan: what is around the face of it, in the scanner's units.
        similarity: brings it to the template.
        surface: there.
        points: of it.
        held: landmarks, there.
        sure: how much landmarks may say beside the surface, from 0 to 1.
        dragged: brings it from there to where it would be were all of the face still.
    """

    scan: Scan
    similarity: Similarity
    surface: Surface
    points: ScanPoints
    held: Held
    sure: float = 1.0
    dragged: Similarity = field(default_factory=Similarity.identity)

    @property
    def doubt(self) -> float:
        """Degrees by which the head may be turned otherwise."""
        cosine = (np.trace(self.dragged.rotation) - 1) / 2
        return _DOUBT * float(np.degrees(np.arccos(np.clip(cosine, -1, 1))))

    def unsure(self, vertices: Points) -> Points:
        """(V,) distance by which vertices may be elsewhere with the head."""
        return _DOUBT * np.asarray(np.linalg.norm(self.dragged(vertices) - vertices, axis=1))


def stillness(elastic: Elastic, expressions: Expressions | None, marks: Marks) -> Points:
    """(V,) how much each vertex tells where the head is, from 0 to 1.

    By what no target of a rig moves; else by how near it is to landmarks of the upper face, beside
    those of the mouth and the jaw.
    """
    if expressions is not None:
        moved = np.linalg.norm(expressions.deltas, axis=2).max(axis=0, initial=0.0)
        return np.asarray(1 / (1 + (moved / (_MOVED * elastic.size)) ** 2) ** 2)
    parts = [
        elastic.rest[[own for name, own in marks.vertices.items() if (name in _STILL) == still]]
        for still in (True, False)
    ]
    if not all(map(len, parts)):
        return np.ones(len(elastic.rest))
    near, far = (np.linalg.norm(elastic.rest[:, None] - own, axis=2).min(axis=1) for own in parts)
    return np.asarray(1 / (1 + (near / np.maximum(far, 1e-12)) ** 4))


def placed_first(scan: Scan, marks: Marks, elastic: Elastic) -> Placed:
    """The first scan of a person, brought to the template.

    Raises:
        CaptureError: There is no such face, or more than one, or it cannot be told where.
    """
    clicks = marks.on(scan.name)
    face, normals = elastic.rest[elastic.outer], elastic.normals(elastic.rest)[elastic.outer]
    if clicks:
        there = {name: np.array(place) for name, place in clicks.items()}
        own = {name: elastic.rest[vertex] for name, vertex in marks.vertices.items()}
        similarity = fit_landmarks(own, there, scan.name).inverse()
        # A scan of the template's own shape is found more exactly by its surface than by clicks.
        laid = laid_over(face, normals, elastic.size, looked_up(scan), similarity, rigid=False)
        if laid.covered > _SHAPED and laid.off < _SAME_SHAPE:
            placed = placed_at(scan, laid.similarity, marks, elastic, elastic.rest)
            missed = placed.held.places - elastic.rest[placed.held.vertices]
            sure = placed.held.sure(laid.off * elastic.size, missed)
            if sure < _UNSURE:
                return replace(placed, sure=sure)
    else:
        require_one_head(scan)
        points = looked_up(scan)
        similarity = found_anywhere(face, normals, elastic.size, points, None, scan.name)
    return placed_at(scan, similarity, marks, elastic, elastic.rest)


def placed_next(
    scan: Scan,
    marks: Marks,
    elastic: Elastic,
    expected: Points,
    before: Similarity | None,
    still: Points | None = None,
) -> Placed:
    """A further scan of a person, brought to where the head was.

    Landmarks and the pose before are guesses; by what is still the place is found, and of all ends
    that one counts which explains most of it.

    Args:
        scan: in the scanner's units.
        marks: landmarks, of this scan or not.
        elastic: the person's neutral.
        expected: (V, 3) the pose before.
        before: what brought the scan before to its place, if it is known.
        still: (V,) how much each vertex tells where the head is, 0 where the neutral's scan shows
            nothing; all alike unless given.

    Raises:
        CaptureError: The head is not in it, or it cannot be told where.
    """
    points, size = looked_up(scan), elastic.size
    still = np.ones(len(expected)) if still is None else still
    shown = elastic.outer & (still > 0)
    # What is still is where it was in the neutral: errors of the poses before do not add up.
    known = elastic.rest if np.ptp(still[shown]) else expected
    face, normals = known[shown], elastic.normals(known)[shown]
    guesses = [] if before is None else [before]
    every = marks.on(scan.name)
    of_still = {name: place for name, place in every.items() if name in _STILL}
    clicks = of_still if len(of_still) >= 4 else every
    if clicks:
        own = {name: elastic.rest[marks.vertices[name]] for name in clicks}
        there = {name: np.array(place) for name, place in clicks.items()}
        guesses.append(_kept(fit_landmarks(own, there, scan.name).inverse(), before))
    found, dragged = None, Similarity.identity()
    if guesses:
        found, dragged = found_near(face, normals, size, points, guesses, still[shown])
    if found is None or not (clicks or (found.covered > _EXPECTED and found.off < _NEAR)):
        require_one_head(scan)
        scale = None if before is None else before.scale
        first = found_anywhere(face, normals, size, points, scale, scan.name)
        if before is None:
            first = laid_over(face, normals, size, points, first, rigid=False).similarity
        found, dragged = found_near(face, normals, size, points, [first], still[shown])
    if not clicks and scan.inside_out:
        _require_not_mirrored(scan, points, face, normals, size, found)
    if found.covered < _EXPECTED / 2:
        raise CaptureError(
            f"{scan.name} covers {found.covered:.0%} of the face of the pose before: it shows"
            " something else, or its landmarks are not where the template has them"
        )
    placed = placed_at(scan, found.similarity, marks, elastic, expected)
    return replace(placed, dragged=found.similarity.inverse().then(dragged))


def looked_up(scan: Scan) -> ScanPoints:
    """Points of a scan, as dense as it takes to find a head in it."""
    area = np.linalg.norm(scan.surface.face_normals, axis=1).sum() / 2
    return ScanPoints(scan.surface, float(np.sqrt(area / _LOOKED_UP)), most=_LOOKED_UP)


def placed_at(
    scan: Scan,
    similarity: Similarity,
    marks: Marks,
    elastic: Elastic,
    expected: Points,
) -> Placed:
    """A scan where it belongs, without what is around the face."""
    moved = similarity(scan.surface.vertices)
    face = expected[elastic.outer]
    low, high = face.min(axis=0), face.max(axis=0)
    margin = _AROUND * (high - low).max()
    inside = ((moved > low - margin) & (moved < high + margin)).all(axis=1)
    kept = inside[scan.surface.triangles].all(axis=1)
    if not kept.any():
        raise CaptureError(
            f"{scan.name}: nothing of it is where the face is expected: its landmarks are not"
            " where the template has them"
        )
    surface = Surface(moved, scan.surface.triangles[kept])
    clicks = marks.on(scan.name)
    held = Held(
        np.array([marks.vertices[name] for name in clicks], dtype=np.int64),
        similarity(np.array(list(clicks.values()), dtype=np.float64).reshape(-1, 3)),
    )
    return Placed(scan.only(kept), similarity, surface, ScanPoints(surface, elastic.edge), held)


def _kept(found: Similarity, before: Similarity | None) -> Similarity:
    """A similarity at the size of the scan before, unless units differ."""
    if before is None or abs(np.log(found.scale / before.scale)) > np.log(_SAME_SIZE):
        return found
    return Similarity(before.scale, found.rotation, found.shift)


def _require_not_mirrored(
    scan: Scan, points: ScanPoints, face: Points, normals: Points, size: float, found: Laid
) -> None:
    """Refuse a scan that fits the pose before only when it is mirrored."""
    mirror = np.diag([-1.0, 1.0, 1.0])
    own = found.similarity
    turned = points.mirrored(mirror)
    # Begun from where the head was found, its middle in the same place.
    middle = face.mean(axis=0)
    back = own.inverse()(middle) @ mirror
    first = Similarity(own.scale, own.rotation, middle - own.scale * own.rotation @ back)
    again = laid_over(face, normals, size, turned, first, rigid=True)
    if again.covered > _EXPECTED and again.off < _MIRRORED * found.off:
        raise CaptureError(f"{scan.name} is mirrored: mirror it back, or export it again")


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
    face: Points, normals: Points, size: float, scan: ScanPoints, scale: float | None, name: str
) -> Similarity:
    """A scan laid over a face without any guess.

    Args:
        face: (N, 3) vertices that a scanner sees.
        normals: (N, 3) of them.
        size: extent of the face.
        scan: in its own units and axes.
        scale: that brings the scan to the size of the face, if it is known.
        name: of the scan.

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
            f"{name}: where the face is in it cannot be told without landmarks: name at least four"
            " points of it, as 'elastomorph landmarks' does"
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
