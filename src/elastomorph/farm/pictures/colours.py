"""The colour picture of a view: lit, with smooth edges, and what shines through on top."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
    count, points = size[0] * size[1], found.points
    own = pixel[found.ray]
    position = np.full((*size, 3), _FAR * extent, dtype=np.float32)
    normal = np.zeros((*size, 3), dtype=np.float32)
    cloth = np.full(size, -1)
    row, column = own // size[1], own % size[1]
    position[row, column], normal[row, column] = points.position, points.normal
    cloth[row, column] = view.subject.cloth[points.triangle]
    far = float(points.position[:, 2].mean()) if len(own) else extent
    wide = float(view.scene.intrinsics[0, 0]) * extent / far
    open_ = hollows(position, normal, wide, extent).reshape(-1)
    edges = _edges(position, normal, cloth, extent)

    lit = np.ones(size, dtype=np.float32)
    lit[row, column] = shadows(view, points, own, size[1], extent)
    depth = np.where(cloth >= 0, position[..., 2], np.inf)
    shares = smoothed(lit, depth, _STEP * extent).reshape(-1)

    inner = ~edges.reshape(-1)[own]
    fine_pixel, fine = _refined(view, edges)
    every = Points.joined([points.only(inner), fine])
    of_pixel = np.concatenate([own[inner], fine_pixel])
    shown = radiance(view, every, shares[of_pixel], open_[of_pixel])[0]
    picture = np.tile(view.scene.background.astype(np.float32), (count, 1))
    middle = len(of_pixel) - len(fine_pixel)
    picture[own[inner]] = shown[:middle]
    _average(picture, fine_pixel, shown[middle:])
    for veil in reversed(found.veils):
        where = pixel[veil.ray]
        veiled = shadows(view, veil.points, where, size[1], extent)
        colour, opacity = radiance(view, veil.points, veiled, open_[where])
        picture[where] += opacity[:, None] * (colour - picture[where])
    codes = np.rint(np.clip(picture, 0, 1) * np.float32(len(_CODES) - 1)).astype(np.int64)
    return np.asarray(_CODES[codes].reshape(*size, 3))


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


def _average(
    picture: NDArray[np.float32], pixel: NDArray[np.int64], shown: NDArray[np.float32]
) -> None:
    """Put the means of finer samples into their pixels; where nothing is seen is background."""
    hits = np.bincount(pixel, minlength=len(picture))
    touched = np.flatnonzero(hits)
    total = np.stack([np.bincount(pixel, own, len(picture))[touched] for own in shown.T], axis=1)
    free = (_FINER**2 - hits[touched])[:, None] * picture[touched]
    picture[touched] = (total + free) / _FINER**2
