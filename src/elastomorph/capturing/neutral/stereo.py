"""Where a surface is, from pairs of photographs that are compared through it.

The photograph of one camera is drawn as a second camera would have taken it if the surface were
right. What has moved between the drawn and the real photograph, by optical flow, says how far the
surface is off at each vertex. Nothing is searched for along lines, as in stereo without a surface:
both photographs look the same but for a few pixels, however differently the cameras stand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera, View
from elastomorph.capturing.geometry.comparing import correlation, flow_engine
from elastomorph.capturing.geometry.curved import curved
from elastomorph.capturing.geometry.sampling import pixel_grid, sampled
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.geometry.table import Table

Points = NDArray[np.float64]
Single = NDArray[np.float32]

# Angle between the cameras of a pair, as seen from the head, in degrees.
_LEAST_ANGLE, _MOST_ANGLE = 4.0, 45.0
# A vertex is looked at if it is turned away from the camera by less than about 78°.
_LEAST_COSINE = 0.2
# How well photographs have to correlate after the flow.
_LEAST_CORRELATION = 0.6
# Pixels: the longest flow, and how far the rays of what was matched may pass each other.
_LONGEST_FLOW, _WIDEST_GAP = 40.0, 1.5
# Side of the square around a pixel that both photographs have to show; a wide one would leave none
# of the lids, which end there in one of them.
_AROUND = 3
# Rays are sent through every second pixel; between them depths are interpolated.
_STEP = 2
# Part of its depth by which a point that is hidden lies behind what hides it.
_BEHIND = 0.003
_FEWEST = 50


@dataclass(frozen=True, eq=False)
class Offsets(Table):
    """How far a surface is off, as single pairs of photographs show it.

    Attributes:
        vertices: (K,) int64 at which.
        offsets: (K,) along its normal, in the units of the surface.
        weights: (K,) larger than 0 and at most 1.
    """

    vertices: NDArray[np.int64]
    offsets: Points
    weights: Points


@dataclass(frozen=True, eq=False)
class _Seen:
    """A photograph and the surface in it.

    Attributes:
        crop: the photograph.
        depth: (h, w) along the axis, through every _STEP-th pixel; 0 where nothing is met.
        visible: (V,) which vertices it shows.
        cosines: (V,) between their normals and the directions to the camera.
    """

    crop: View
    depth: Single
    visible: NDArray[np.bool_]
    cosines: Points


def pairs_of(cameras: Sequence[Camera], middle: Points, each: int) -> list[tuple[int, int]]:
    """For each camera the `each` nearest others by angle, as seen from (3,) middle of the head."""
    towards = np.array([camera.position for camera in cameras]) - middle
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    angles = np.degrees(np.arccos(np.clip(towards @ towards.T, -1, 1)))
    found: list[tuple[int, int]] = []
    for first, mine in enumerate(angles):
        fit = (mine > _LEAST_ANGLE) & (mine < _MOST_ANGLE)
        others = [int(second) for second in np.argsort(mine, kind="stable") if fit[second]]
        found += [(first, second) for second in others[:each]]
    return found


def offsets_from(
    crops: Sequence[View],
    surface: Surface,
    chosen: NDArray[np.bool_],
    pairs: Sequence[tuple[int, int]],
    tolerance: float,
) -> Offsets:
    """How far vertices of a surface are off, from photographs.

    Args:
        crops: photographs.
        surface: near what they show, with all that may hide it.
        chosen: (V,) the vertices that are asked about.
        pairs: of photographs, as indices; the second is drawn as the first would see it.
        tolerance: how far before a vertex something may stand without hiding it, in the units of
            the surface.
    """
    fine = curved(surface)
    seen = [_see(crop, surface, fine, chosen, tolerance) for crop in crops]
    engine = flow_engine()
    found = []
    for first, group in groupby(sorted(pairs), key=lambda pair: pair[0]):
        reference = seen[first]
        places, met = _places(reference)
        for _, second in group:
            both = np.flatnonzero(reference.visible & seen[second].visible)
            if len(both) >= _FEWEST:
                found.append(_compared(reference, seen[second], places, met, both, surface, engine))
    none = Offsets(np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0))
    return Offsets.join([none, *found])


def _see(
    crop: View, surface: Surface, fine: Surface, chosen: NDArray[np.bool_], tolerance: float
) -> _Seen:
    hits = fine.cast(crop.camera.position, crop.camera.directions(_STEP))
    depth = np.where(hits.met, hits.depths, 0).astype(np.float32)
    some = np.flatnonzero(chosen)
    visible = np.zeros(len(chosen), dtype=bool)
    cosines = np.zeros(len(chosen))
    points = surface.vertices[some]
    visible[some], cosines[some] = surface.visible(
        crop.camera,
        points,
        surface.normals[some],
        least_cosine=_LEAST_COSINE,
        tolerance=tolerance,
    )
    if crop.mask is not None:
        mine = np.flatnonzero(visible)
        visible[mine] = crop.usable(crop.camera.project(surface.vertices[mine])[0])
    return _Seen(crop, depth, visible, cosines)


def _places(seen: _Seen) -> tuple[Points, NDArray[np.bool_]]:
    """(H, W, 3) what each pixel of a photograph looks at, and (H, W) where that is the surface."""
    import cv2

    camera = seen.crop.camera
    width, height = camera.size
    x, y = (each / np.float32(_STEP) for each in pixel_grid(width, height))
    # Beside the surface a depth lies between that of the surface and nothing, and is not used.
    depth: Any = cv2.remap(seen.depth, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    share: Any = cv2.remap(
        (seen.depth > 0).astype(np.float32), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    met = share > 0.999
    places = camera.directions() * np.where(met, depth, 1)[..., None] + camera.position
    return places, met


def _compared(
    first: _Seen,
    second: _Seen,
    places: Points,
    met: NDArray[np.bool_],
    some: NDArray[np.int64],
    surface: Surface,
    engine: Any,
) -> Offsets:
    """What one pair of photographs says of some vertices."""
    import cv2

    drawn, where, known = _drawn(second, places, met)
    real = np.where(met, first.crop.grey, 0).astype(np.uint8)
    # Where the second camera sees nothing of it, the photograph itself stands in: nothing moves.
    drawn[met & ~known] = real[met & ~known]
    moved: Any = engine.calc(real, drawn, None)
    start = first.crop.camera.project(surface.vertices[some])[0]
    step = sampled(moved, start)
    width, height = first.crop.camera.size
    x, y = pixel_grid(width, height)
    again: Any = cv2.remap(drawn, x + moved[..., 0], y + moved[..., 1], cv2.INTER_LINEAR)
    alike = sampled(correlation(real, again), start)
    sure = sampled(
        cv2.erode(known.astype(np.uint8), np.ones((_AROUND, _AROUND))).astype(np.float32), start
    )
    goal = sampled(where, start + step)
    found, gap = _crossing(first.crop.camera, start, second.crop.camera, goal)
    good = (alike > _LEAST_CORRELATION) & (gap < _WIDEST_GAP) & (sure > 0.999)
    good &= np.abs(step).max(axis=1) < _LONGEST_FLOW
    some, found = some[good], found[good]
    offsets = np.einsum("ij,ij->i", found - surface.vertices[some], surface.normals[some])
    apart = _sine(first.crop.camera, second.crop.camera, surface.vertices[some])
    weights = alike[good] * first.cosines[some] * second.cosines[some] * apart
    return Offsets(some, offsets, weights)


def _drawn(
    seen: _Seen, places: Points, met: NDArray[np.bool_]
) -> tuple[NDArray[np.uint8], Single, NDArray[np.bool_]]:
    """A photograph as another camera would have taken it, where from, and where it shows that."""
    import cv2

    pixels, depths = seen.crop.camera.project(places)
    where = np.where(met[..., None], pixels, -9).astype(np.float32)
    drawn: Any = cv2.remap(seen.crop.grey, where[..., 0], where[..., 1], cv2.INTER_LINEAR)
    coarse = where / np.float32(_STEP)
    front: Any = cv2.remap(seen.depth, coarse[..., 0], coarse[..., 1], cv2.INTER_NEAREST)
    known = met & (front > 0) & (depths < front * (1 + _BEHIND))
    return np.asarray(drawn), where, np.asarray(known)


def _crossing(a: Camera, in_a: Points, b: Camera, in_b: Points) -> tuple[Points, Points]:
    """(N, 3) points on rays of a that are nearest to rays of b, and how far off in b, px."""
    along, other = a.through(in_a), b.through(in_b)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    other /= np.linalg.norm(other, axis=1, keepdims=True)
    between = a.position - b.position
    cosine = np.einsum("ij,ij->i", along, other)
    far = cosine * (other @ between) - along @ between
    far /= np.maximum(1 - cosine**2, 1e-12)
    points = a.position + far[:, None] * along
    return points, np.linalg.norm(b.project(points)[0] - in_b, axis=1)


def _sine(a: Camera, b: Camera, points: Points) -> Points:
    """(N,) of the angles between the directions from (N, 3) points to two cameras."""
    to_a, to_b = a.position - points, b.position - points
    lengths = np.linalg.norm(to_a, axis=1) * np.linalg.norm(to_b, axis=1)
    sines: Points = np.linalg.norm(np.cross(to_a, to_b), axis=1) / lengths
    return sines
