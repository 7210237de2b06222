"""Brings a scan to the face that it shows, and cuts away what is around that."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.similarity import Similarity
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.landmarks.landmarks import fit_landmarks
from elastomorph.capturing.scans.alignment import Laid, found_anywhere, laid_over
from elastomorph.capturing.scans.correspondence import ScanPoints
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
    """

    scan: Scan
    similarity: Similarity
    surface: Surface
    points: ScanPoints
    held: Held


def placed_first(scan: Scan, marks: Marks, elastic: Elastic) -> Placed:
    """The first scan of a person, brought to the template.

    Raises:
        CaptureError: There is no such face, or more than one, or it cannot be told where.
    """
    clicks = marks.on(scan.name)
    if clicks:
        there = {name: np.array(place) for name, place in clicks.items()}
        own = {name: elastic.rest[vertex] for name, vertex in marks.vertices.items()}
        similarity = fit_landmarks(own, there, scan.name).inverse()
    else:
        require_one_head(scan)
        face, normals = _seen(elastic, elastic.rest)
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
) -> Placed:
    """A further scan of a person, brought to where the head was.

    Args:
        scan: in the scanner's units.
        marks: landmarks, of this scan or not.
        elastic: the person's neutral.
        expected: (V, 3) the pose before.
        before: what brought the scan before to its place, if it is known.

    Raises:
        CaptureError: The head is not in it, or it cannot be told where.
    """
    points = looked_up(scan)
    face, normals = _seen(elastic, expected)

    def laid(first: Similarity, rigid: bool = True) -> Laid:
        return laid_over(face, normals, elastic.size, points, first, rigid=rigid)

    clicks = marks.on(scan.name)
    found: Laid | None
    if clicks:
        still = [name for name in clicks if name in _STILL]
        some = still if len(still) >= 4 else list(clicks)
        own = {name: elastic.rest[marks.vertices[name]] for name in some}
        there = {name: np.array(clicks[name]) for name in own}
        found = laid(_kept(fit_landmarks(own, there, scan.name).inverse(), before))
    else:
        found = None if before is None else laid(before)
        if found is None or found.covered < _EXPECTED or found.off > _NEAR:
            require_one_head(scan)
            size, reach = elastic.size, None if before is None else before.scale
            found = laid(
                _named(scan.name, lambda: found_anywhere(face, normals, size, points, reach)),
                rigid=before is not None,
            )
        if scan.inside_out:
            _require_not_mirrored(scan, points, face, normals, elastic.size, found)
    if found.covered < _EXPECTED / 2:
        raise CaptureError(
            f"{scan.name} covers {found.covered:.0%} of the face of the pose before: it shows"
            " something else, or its landmarks are not where the template has them"
        )
    return _placed(scan, found.similarity, marks, elastic, expected)


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
