"""Brings a scan to the face that it shows, and cuts away what is around that."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.similarity import Similarity
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.landmarks.landmarks import fit_landmarks
from elastomorph.capturing.scans.alignment import Laid, found_anywhere, found_near, laid_over
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
    face, normals = _seen(elastic, elastic.rest)
    if clicks:
        there = {name: np.array(place) for name, place in clicks.items()}
        own = {name: elastic.rest[vertex] for name, vertex in marks.vertices.items()}
        similarity = fit_landmarks(own, there, scan.name).inverse()
        # A scan of the template's own shape is found more exactly by its surface than by clicks.
        laid = laid_over(face, normals, elastic.size, looked_up(scan), similarity, rigid=False)
        if laid.covered > _SHAPED and laid.off < _SAME_SHAPE:
            placed = _placed(scan, laid.similarity, marks, elastic, elastic.rest)
            missed = placed.held.places - elastic.rest[placed.held.vertices]
            sure = placed.held.sure(laid.off * elastic.size, missed)
            if sure < _UNSURE:
                return replace(placed, sure=sure)
    else:
        require_one_head(scan)
        similarity = _named(
            scan.name,
            lambda: found_anywhere(face, normals, elastic.size, looked_up(scan), None),
        )
    return _placed(scan, similarity, marks, elastic, elastic.rest)


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
        first = _named(scan.name, lambda: found_anywhere(face, normals, size, points, scale))
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
    placed = _placed(scan, found.similarity, marks, elastic, expected)
    return replace(placed, dragged=found.similarity.inverse().then(dragged))


def placed_again(scan: Scan, similarity: Similarity, marks: Marks, elastic: Elastic) -> Placed:
    """The first scan where an earlier run has brought it."""
    return _placed(scan, similarity, marks, elastic, elastic.rest)


def looked_up(scan: Scan) -> ScanPoints:
    """Points of a scan, as dense as it takes to find a head in it."""
    area = np.linalg.norm(scan.surface.face_normals, axis=1).sum() / 2
    return ScanPoints(scan.surface, float(np.sqrt(area / _LOOKED_UP)), most=_LOOKED_UP)


def _placed(
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


def _seen(elastic: Elastic, vertices: Points) -> tuple[Points, Points]:
    """Vertices of the skin, and their normals."""
    return vertices[elastic.outer], elastic.normals(vertices)[elastic.outer]


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


def _named(name: str, find: Callable[[], Similarity]) -> Similarity:
    try:
        return find()
    except CaptureError as problem:
        raise CaptureError(f"{name}: {problem}") from None
