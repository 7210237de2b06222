"""Photographs of scans with colours, by cameras that nobody had to hold.

The same cameras look at the neutral's scan and at a pose's. What the neutral shows in its pictures
is then followed in those of the pose, so that correspondence comes from the skin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.cameras.frames import paired
from elastomorph.capturing.geometry.camera import Camera, View
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.scans.nonrigid import Elastic
from elastomorph.capturing.scans.placing import Placed
from elastomorph.capturing.scans.skin import Skin
from elastomorph.capturing.tracking.matches import Matches
from elastomorph.capturing.tracking.reference import Reference
from elastomorph.capturing.tracking.tracking import TrackedPose, follow

Points = NDArray[np.float64]

# Cameras, chosen among this many directions, each this many extents away.
_CAMERAS, _DIRECTIONS, _AWAY = 18, 150, 2.5
# Pixels that the extent is long at, and how much room is left around it.
_PIXELS, _ROOM = 1100.0, 1.1
# Points of the skin in each picture, and fewest in both that a pose is begun by.
_FEATURES, _FEWEST = 1500, 60
# Least cosine at which a camera sees a vertex well.
_WELL = 0.45


def cameras_around(elastic: Elastic, wanted: Points) -> list[Camera]:
    """Cameras by which every vertex of the skin is seen well by several.

    Args:
        elastic: a face.
        wanted: (V,) how much each vertex counts.
    """
    vertices, normals = elastic.rest, elastic.normals(elastic.rest)
    skin = elastic.outer
    middle = np.average(vertices[skin], axis=0, weights=wanted[skin])
    ways = _sphere(_DIRECTIONS)
    seen = np.maximum(normals[skin] @ ways.T - _WELL, 0)
    times = np.zeros(np.count_nonzero(skin))
    found: list[Camera] = []
    for _ in range(_CAMERAS):
        best = int((seen * (wanted[skin] / (1 + times) ** 2)[:, None]).sum(axis=0).argmax())
        times += seen[:, best] > 0
        seen[:, best] = 0
        found.append(_looking(middle, ways[best], elastic.size, f"{len(found):02d}"))
    return found


def photographed(camera: Camera, surface: Surface, skin: Skin) -> View:
    """What a camera sees of a scan, as bright as its own colours."""
    import cv2

    hits = surface.seen(camera)
    colour = skin.at(hits.triangles, hits.weights)
    grey: Any = cv2.cvtColor(colour, cv2.COLOR_RGB2GRAY)
    return View(camera, grey, hits.met)


@dataclass(frozen=True, eq=False)
class Shown:
    """A neutral that can be followed.

    Attributes:
        reference: it and its virtual photographs.
        surface: of its scan.
    """

    reference: Reference
    surface: Surface


def shown_neutral(elastic: Elastic, neutral: Placed, wanted: Points) -> Shown | None:
    """The neutral as its virtual photographs show it; None where its scan has no colours."""
    if neutral.scan.skin is None:
        return None
    cameras = cameras_around(elastic, wanted)
    views = [photographed(camera, neutral.surface, neutral.scan.skin) for camera in cameras]
    return Shown(Reference(elastic.rest, elastic.triangles, views), neutral.surface)


def followed(neutral: Shown, pose: Placed, skin: Skin, start: Points) -> TrackedPose:
    """The vertices of the neutral in virtual photographs of a pose.

    Args:
        neutral: what is followed.
        pose: the scan of the pose.
        skin: its colours.
        start: (V, 3) as its surface alone has it.
    """
    before = neutral.reference.views
    views = [photographed(view.camera, pose.surface, skin) for view in before]
    found = [
        _alike(one, neutral.surface, other, pose.surface)
        for one, other in zip(before, views, strict=True)
    ]
    points = [np.concatenate(each) for each in zip(*found, strict=True)]
    matches = Matches(*points) if len(points[0]) >= _FEWEST else None
    return follow(neutral.reference, views, start=start, matches=matches)


def _alike(one: View, first: Surface, other: View, second: Surface) -> tuple[Points, Points]:
    """Points of two scans that look alike to one camera (SIFT)."""
    (pixels, own), (goals, there) = _features(one), _features(other)
    pairs = paired(own, there)
    starts, ends = (
        _lifted(view.camera, surface, at[some])
        for view, surface, at, some in (
            (one, first, pixels, pairs[:, 0]),
            (other, second, goals, pairs[:, 1]),
        )
    )
    met = np.isfinite(starts).all(axis=1) & np.isfinite(ends).all(axis=1)
    return starts[met], ends[met]


def _features(view: View) -> tuple[Points, NDArray[np.float32]]:
    """(N, 2) pixels and (N, 128) descriptors of length 1."""
    import cv2

    mask: Any = None if view.mask is None else view.mask.astype(np.uint8)
    finder: Any = getattr(cv2, "SIFT_create")(_FEATURES, contrastThreshold=0.015)  # noqa: B009
    found, described = finder.detectAndCompute(view.grey, mask)
    if described is None:
        return np.zeros((0, 2)), np.zeros((0, 128), dtype=np.float32)
    lengths = np.maximum(np.linalg.norm(described, axis=1, keepdims=True), 1e-12)
    return np.array([own.pt for own in found]), (described / lengths).astype(np.float32)


def _lifted(camera: Camera, surface: Surface, pixels: Points) -> Points:
    """(N, 3) points of a surface at pixels; infinite where there is none."""
    ways = camera.through(pixels)
    depths = surface.cast(camera.position, ways).depths
    with np.errstate(invalid="ignore"):
        return np.asarray(camera.position + depths[:, None] * ways)


def _looking(middle: Points, way: Points, size: float, name: str) -> Camera:
    """A camera in a direction that looks at the middle of the face."""
    away = _AWAY * size
    forward = -way
    side = np.cross([0.0, 1.0, 0.0] if abs(way[1]) < 0.9 else [0.0, 0.0, 1.0], forward)
    side /= np.linalg.norm(side)
    rotation = np.stack([side, np.cross(forward, side), forward])
    pixels = round(_ROOM * _PIXELS)
    return Camera(
        name,
        (pixels, pixels),
        _PIXELS * _AWAY,
        np.full(2, (pixels - 1) / 2),
        0.0,
        rotation,
        -rotation @ (middle + away * way),
    )


def _sphere(count: int) -> Points:
    """(count, 3) directions, spread evenly (a Fibonacci spiral)."""
    number = np.arange(count)
    z = 1 - 2 * (number + 0.5) / count
    angle = number * np.pi * (3 - np.sqrt(5))
    across = np.sqrt(1 - z**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)
