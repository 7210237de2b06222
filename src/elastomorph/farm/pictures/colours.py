"""The colour picture of a view: lit, with smooth edges, and what shines through on top."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from elastomorph.draw.textures import encoded
from elastomorph.farm.pictures.light import hollows, shadows, smoothed
from elastomorph.farm.pictures.shading import radiance
from elastomorph.farm.pictures.view import Points, Seen, View

__all__ = ["colour_picture"]

_FINER = 2
"""Samples across a pixel at an edge; elsewhere its middle tells its colour."""
_STEP = 0.01
"""In D: neighbours farther apart in depth have an edge between them."""
_BEND = 0.85
"""Least cosine of the normals of neighbours without an edge between them."""
_FAR = 1e6
_CODES = np.rint(255 * encoded(np.linspace(0, 1, 4096))).astype(np.uint8)


@dataclass(frozen=True, eq=False)
class _Middles:
    """What the middles of pixels show, (H, W).

    Attributes:
        depth: Along the camera's axis; infinite where nothing is.
        edges: Whether a pixel differs from one beside it.
        lit: How much of the lamp it sees, see `shadows`.
        open_: How much of the light from all around, see `hollows`.
    """

    depth: NDArray[np.float32]
    edges: NDArray[np.bool_]
    lit: NDArray[np.float32]
    open_: NDArray[np.float32]


def colour_picture(
    view: View, found: Seen, pixel: NDArray[np.int64], size: tuple[int, int], extent: float
) -> NDArray[np.uint8]:
    """(H, W, 3) sRGB.

    Args:
        view: The subject before the camera.
        found: What rays through the middles of pixels meet.
        pixel: (N,) row · width + column of each of those rays.
        size: Height and width.
        extent: D.
    """
    own, far = pixel[found.ray], _STEP * extent
    middles = _middles(view, found.points, own, size, extent)
    inner = ~middles.edges.reshape(-1)[own]
    fine_pixel, fine = _refined(view, middles.edges)
    every = Points.joined([found.points.only(inner), fine])
    of_pixel = np.concatenate([own[inner], fine_pixel])
    count = len(of_pixel) - len(fine_pixel)
    behind = np.zeros(len(of_pixel))
    behind[count:] = fine.position[:, 2] - middles.depth.reshape(-1)[fine_pixel]
    lit, open_ = (
        _taken(each, of_pixel, behind > far, behind < -far) for each in (middles.lit, middles.open_)
    )
    shown = radiance(view, every, lit, open_)[0]
    picture = np.tile(view.scene.background.astype(np.float32), (size[0] * size[1], 1))
    picture[own[inner]] = shown[:count]
    _average(picture, fine_pixel, shown[count:])
    for veil in reversed(found.veils):
        where = pixel[veil.ray]
        veiled = shadows(view, veil.points, where, size[1], extent)
        colour, opacity = radiance(view, veil.points, veiled, middles.open_.reshape(-1)[where])
        picture[where] += opacity[:, None] * (colour - picture[where])
    codes = np.rint(np.clip(picture, 0, 1) * np.float32(len(_CODES) - 1)).astype(np.int64)
    return np.asarray(_CODES[codes].reshape(*size, 3))


def _middles(
    view: View, points: Points, pixel: NDArray[np.int64], size: tuple[int, int], extent: float
) -> _Middles:
    row, column = pixel // size[1], pixel % size[1]
    position = np.full((*size, 3), _FAR * extent, dtype=np.float32)
    normal = np.zeros((*size, 3), dtype=np.float32)
    cloth, lit = np.full(size, -1), np.ones(size, dtype=np.float32)
    position[row, column], normal[row, column] = points.position, points.normal
    cloth[row, column] = view.subject.cloth[points.triangle]
    lit[row, column] = shadows(view, points, pixel, size[1], extent)
    depth = np.where(cloth >= 0, position[..., 2], np.inf)
    mean = float(points.position[:, 2].mean()) if len(pixel) else extent
    wide = float(view.scene.intrinsics[0, 0]) * extent / mean
    return _Middles(
        depth=depth,
        edges=_edges(position, normal, cloth, extent),
        lit=smoothed(lit, depth, _STEP * extent),
        open_=hollows(position, normal, wide, extent),
    )


def _edges(
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    cloth: NDArray[np.int64],
    extent: float,
) -> NDArray[np.bool_]:
    """(H, W) pixels that differ from the next one in material, depth or direction."""
    edges = np.zeros(cloth.shape, dtype=bool)
    depth = position[..., 2]
    for one, other in ((np.s_[:-1], np.s_[1:]), (np.s_[:, :-1], np.s_[:, 1:])):
        cosine = np.einsum("hwk,hwk->hw", normal[one], normal[other])
        apart = np.abs(depth[one] - depth[other]) > _STEP * extent
        differ = (cloth[one] != cloth[other]) | ((cloth[one] >= 0) & (apart | (cosine < _BEND)))
        edges[one] |= differ
        edges[other] |= differ
    return edges


def _refined(view: View, edges: NDArray[np.bool_]) -> tuple[NDArray[np.int64], Points]:
    """What is seen at finer samples of the pixels at edges, and the pixel that each is of."""
    row, column = np.nonzero(edges)
    inside = (np.arange(_FINER) + 0.5) / _FINER - 0.5
    down, right = (own.reshape(-1) for own in np.meshgrid(inside, inside, indexing="ij"))
    x, y = column[:, None] + right, row[:, None] + down
    found = view.look(np.column_stack([x.reshape(-1), y.reshape(-1)]))
    of_sample = (row * edges.shape[1] + column).repeat(_FINER**2)
    return of_sample[found.ray], found.points


def _taken(
    shares: NDArray[np.float32],
    pixel: NDArray[np.int64],
    beyond: NDArray[np.bool_],
    before: NDArray[np.bool_],
) -> NDArray[np.float32]:
    """(N,) of (H, W) shares of light at pixels, for samples beyond or before what these show.

    Those are of a surface that a pixel beside shows: the darkest beyond an edge, as in a nostril
    or between lips, the brightest before it.
    """
    found = shares.reshape(-1)[pixel]
    found[beyond] = minimum_filter(shares, 3).reshape(-1)[pixel[beyond]]
    found[before] = maximum_filter(shares, 3).reshape(-1)[pixel[before]]
    return np.asarray(found)


def _average(
    picture: NDArray[np.float32], pixel: NDArray[np.int64], shown: NDArray[np.float32]
) -> None:
    """Put the means of finer samples into their pixels; where nothing is seen is background."""
    hits = np.bincount(pixel, minlength=len(picture))
    touched = np.flatnonzero(hits)
    total = np.stack([np.bincount(pixel, own, len(picture))[touched] for own in shown.T], axis=1)
    free = (_FINER**2 - hits[touched])[:, None] * picture[touched]
    picture[touched] = (total + free) / _FINER**2
