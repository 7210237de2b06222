"""The neutral's photographs, carried by the surface into those of a pose, and what they miss by.

Each pixel of a pose's photograph looks at a point of the surface as it is assumed to be; that
point was photographed in the neutral. The picture this makes would be the photograph itself if
the surface were right: the optical flow between them says how far each vertex is off.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.capturing.geometry.camera import Camera, View
from elastomorph.capturing.geometry.comparing import correlation, flow_engine
from elastomorph.capturing.geometry.sampling import pixel_grid, sampled
from elastomorph.capturing.geometry.surface import Surface
from elastomorph.capturing.tracking.observations import Observations, supported
from elastomorph.capturing.tracking.reference import Level

Points = NDArray[np.float64]
Single = NDArray[np.float32]
Picture = NDArray[np.uint8]

# Photographs of the neutral that each of the pose is compared with.
_SOURCES = 2
# Correlation below which nothing is believed, and pixels by which the way back may miss.
_ALIKE, _BACK = 0.5, 0.7
# Photographs that have to show a vertex to be believed, and part of those that look at it.
_FEWEST, _SUPPORT = 3, 0.4
# Pixels around the head that are kept of a photograph.
_MARGIN = 24
# Side of the square around a pixel, and the part of it that has to be known.
_BOX, _AROUND = 9, 0.85


def by_flow(level: Level, views: Sequence[View], vertices: Points) -> Observations:
    """What optical flow from some photographs of the neutral into each of the pose shows.

    Args:
        level: the neutral and its photographs.
        views: photographs of the pose, of the same size.
        vertices: (V, 3) of the pose as assumed so far.
    """
    neutral = level.surface.vertices
    posed = Surface(vertices, level.surface.triangles)
    cameras = [view.camera for view in level.views]
    found = []
    offered = np.zeros(len(vertices))
    for number, view in enumerate(views):
        seen, cosines = level.looked(posed, view.camera)
        seen &= view.usable(view.camera.project(vertices)[0])
        offered += seen & level.seen[0].any(axis=0)
        near = _nearest(cameras, neutral.mean(axis=0), view.camera, vertices.mean(axis=0))
        taken = [(level.views[i], level.depths[i], level.seen[0][i]) for i in near[:_SOURCES]]
        found += _missed(number, view, posed, neutral, taken, (seen, cosines))
    fewest = np.maximum(_FEWEST, _SUPPORT * offered)
    return supported(Observations.join([Observations.none(), *found]), len(vertices), fewest)


def _warped(
    places: Points, met: NDArray[np.bool_], target: Picture, view: View, depth: Single
) -> tuple[Picture, NDArray[np.bool_]]:
    """A photograph of the neutral as the pose's camera would have taken it, and where it shows it.

    Where the neutral shows nothing the pose's own photograph stands in: nothing moves there.

    Args:
        places: (H, W, 3) where on the neutral lies what each pixel of the pose's photograph sees.
        met: (H, W) where it sees the surface.
        target: (H, W) uint8 the pose's photograph.
        view: of the neutral.
        depth: of the neutral in that view, infinite beside it; may be of fewer pixels.
    """
    import cv2

    pixels, depths = view.camera.project(places)
    where = np.where(met[..., None], pixels, -9.0).astype(np.float32)
    picture: Any = cv2.remap(view.grey, where[..., 0], where[..., 1], cv2.INTER_LINEAR)
    step = view.camera.size[0] / depth.shape[1]
    coarse = ((where + 0.5) / np.float32(step) - 0.5).astype(np.float32)
    front: Any = cv2.remap(depth, coarse[..., 0], coarse[..., 1], cv2.INTER_NEAREST, borderValue=-1)
    known = met & view.camera.inside(pixels, 1) & (depths < front * 1.004)
    return np.where(known, picture, target), known


def _around(known: NDArray[np.bool_]) -> Single:
    """(H, W) which part of the surroundings of each pixel is known."""
    import cv2

    found: Any = cv2.boxFilter(known.astype(np.float32), -1, (_BOX, _BOX))
    return np.asarray(found)


def _flow_between(engine: Any, one: Picture, other: Picture) -> tuple[Single, Single, Single]:
    """(H, W, 2) flow, (H, W) pixels by which the way back misses, and (H, W) correlation."""
    import cv2

    there: Any = engine.calc(one, other, None)
    back: Any = engine.calc(other, one, None)
    columns, rows = pixel_grid(*one.shape[::-1])
    x, y = columns + there[..., 0], rows + there[..., 1]
    round_trip = np.linalg.norm(there + cv2.remap(back, x, y, cv2.INTER_LINEAR), axis=-1)
    found: Any = cv2.remap(other, x, y, cv2.INTER_LINEAR)
    return there, np.asarray(round_trip, dtype=np.float32), correlation(one, found)


def _cropped(camera: Camera, points: Points) -> tuple[slice, slice]:
    """The rows and columns of a photograph that hold the points, and a margin."""
    pixels, depths = camera.project(points)
    pixels = pixels[depths > 0]
    if not len(pixels):
        return slice(0, 0), slice(0, 0)
    low = np.maximum(np.floor(pixels.min(axis=0)).astype(int) - _MARGIN, 0)
    high = np.minimum(np.ceil(pixels.max(axis=0)).astype(int) + _MARGIN, camera.size)
    return slice(int(low[1]), int(max(high[1], low[1]))), slice(
        int(low[0]), int(max(high[0], low[0]))
    )


def _nearest(neutral: list[Camera], middle: Points, camera: Camera, around: Points) -> list[int]:
    """Cameras of the neutral by how alike they look at it as another camera looks at the pose."""
    wanted = camera.position - around
    ways = np.array([each.position - middle for each in neutral])
    cosines = ways @ wanted / np.linalg.norm(ways, axis=1) / np.linalg.norm(wanted)
    return [int(i) for i in np.argsort(-cosines, kind="stable")]


def _missed(
    number: int,
    view: View,
    posed: Surface,
    neutral: Points,
    sources: list[tuple[View, Single, NDArray[np.bool_]]],
    seen: tuple[NDArray[np.bool_], Points],
) -> list[Observations]:
    """Where one photograph of a pose shows the vertices, by each of some neutral photographs.

    Args:
        number: of the photograph.
        view: of the pose.
        posed: the surface as assumed so far.
        neutral: (V, 3) the neutral's vertices.
        sources: neutral views, their depths and (V,) which vertices they see.
        seen: (V,) which vertices the photograph sees, and their cosines.
    """
    rows, columns = _cropped(view.camera, posed.vertices)
    target = np.ascontiguousarray(view.grey[rows, columns])
    if min(target.shape) < 32:
        return []
    x, y = np.meshgrid(np.arange(columns.start, columns.stop), np.arange(rows.start, rows.stop))
    hits = posed.cast(view.camera.position, view.camera.through(np.stack([x, y], axis=-1)))
    places = posed.at(hits, neutral)
    found = []
    engine = flow_engine()
    pixels = view.camera.project(posed.vertices)[0]
    corner = np.array([columns.start, rows.start])
    for source, depth, known in sources:
        picture, shown = _warped(places, hits.met, target, source, depth)
        there, back, alike = _flow_between(engine, picture, target)
        both = np.flatnonzero(seen[0] & known)
        at = (pixels[both] - corner).astype(np.float32)
        maps = np.dstack([there, back, alike, _around(shown)])
        values = sampled(maps, at)
        good = (values[:, 3] > _ALIKE) & (values[:, 2] < _BACK) & (values[:, 4] > _AROUND)
        both, values = both[good], values[good]
        weight = values[:, 3] * seen[1][both]
        found.append(
            Observations(
                np.full(len(both), number),
                both,
                pixels[both] + values[:, :2],
                weight[:, None, None] * np.eye(2),
                values[:, 3].astype(np.float64),
            )
        )
    return found
