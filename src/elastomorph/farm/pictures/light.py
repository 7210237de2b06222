"""What light reaches points of a surface: shadows of the lamp, and hollows that are dark."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from elastomorph.farm.pictures.view import Points, View

__all__ = ["hollows", "shadows", "smoothed"]

Shares = NDArray[np.float32]

_LAMP = 0.07
"""Radius of the lamp over its distance."""
_RAYS, _TILE = 3, 3
_GOLDEN = np.pi * (3 - np.sqrt(5))
_LIFT, _LIFT_TURNED = 0.003, 0.05  # of D
_DARK = -0.35
"""Cosine below which no light comes round the edge of what is lit, see `shading`."""
_REACH = 0.11
"""How far hollows are felt, in D: mouth, nostrils and the corners of the eyes are dark."""
_DIRECTIONS = 16
_DARKNESS, _LEVEL = 1.1, 0.02


def shadows(
    view: View, points: Points, pixel: NDArray[np.int64], width: int, extent: float
) -> Shares:
    """(N,) how much of the lamp each point sees, from 0 to 1.

    Rays start a little off the surface, farther where it is turned from the lamp, for smooth
    normals reach beyond the polygons they are of. Each of three by three pixels asks other places
    of the lamp, so that their mean has seen all of it.

    Args:
        view: What the points are on.
        points: N of them.
        pixel: (N,) row · width + column, where they are seen.
        width: Of the picture.
        extent: D.
    """
    lamp = view.scene.lamp
    across = np.cross(lamp, [0.0, 1.0, 0.0] if abs(lamp[1]) < 0.9 else [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    along = np.cross(lamp, across)
    facing = points.normal @ lamp.astype(np.float32)
    asked = np.flatnonzero(facing > _DARK)
    lifted = _LIFT + _LIFT_TURNED * np.clip(0.3 - facing[asked], 0, 0.6)
    start = points.position[asked] + points.normal[asked] * (extent * lifted)[:, None]
    own = pixel[asked] % width % _TILE + _TILE * (pixel[asked] // width % _TILE)
    seen = np.zeros(len(facing), dtype=np.float32)
    # Places on the lamp: turns by the golden angle, evenly spread in the disc.
    places = np.arange(_RAYS * _TILE**2)
    radius = _LAMP * np.sqrt((places + 0.5) / len(places))
    aside = np.stack([radius * turn(places * _GOLDEN) for turn in (np.cos, np.sin)], axis=1)
    ways = lamp + aside[:, :1] * across + aside[:, 1:] * along
    for ray in range(_RAYS):
        seen[asked] += view.solid.free(start, ways[own + ray * _TILE**2])
    return seen / np.float32(_RAYS)


def smoothed(shares: Shares, depth: NDArray[np.float32], step: float) -> Shares:
    """(H, W) means of three by three pixels, of those within a step in depth.

    Where there is nothing, which is at a depth of infinity, of all that are there.
    """
    height, width = shares.shape
    around = np.pad(shares, 1)
    beyond = np.pad(depth, 1, constant_values=np.inf)
    total, count = np.zeros_like(shares), np.zeros_like(shares)
    nothing = ~np.isfinite(depth)
    here = np.where(nothing, 0, depth)
    for down in range(3):
        for right in range(3):
            box = np.s_[down : down + height, right : right + width]
            alike = (np.abs(beyond[box] - here) < step) | (nothing & np.isfinite(beyond[box]))
            total += np.where(alike, around[box], 0)
            count += alike
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), 1))


def hollows(
    position: NDArray[np.float32], normal: NDArray[np.float32], pixels: float, extent: float
) -> Shares:
    """(H, W) how much of the light from all around reaches each pixel, from 0 to 1.

    What stands around within reach takes light away (McGuire et al., the Alchemy screen-space
    ambient obscurance algorithm, 2011).

    Args:
        position: (H, W, 3) in the camera's axes; far away where there is nothing.
        normal: (H, W, 3) unit.
        pixels: How many of them D takes in the picture.
        extent: D.
    """
    height, width = position.shape[:2]
    reach = max(2, round(_REACH * pixels))
    padded = np.pad(position, ((reach, reach), (reach, reach), (0, 0)), mode="edge")
    taken = np.zeros((height, width), dtype=np.float32)
    least = np.float32((_LEVEL * extent) ** 2)
    for step in range(_DIRECTIONS):
        radius = reach * np.sqrt((step + 0.5) / _DIRECTIONS)
        angle = step * _GOLDEN
        x, y = (reach + round(float(radius * turn(angle))) for turn in (np.cos, np.sin))
        way = padded[y : y + height, x : x + width] - position
        squared = np.einsum("hwk,hwk->hw", way, way)
        above = np.einsum("hwk,hwk->hw", way, normal) - np.float32(0.004 * extent)
        taken += np.maximum(above, 0) / (squared + least)
    share = taken * np.float32(_DARKNESS * 2 * _REACH * extent / _DIRECTIONS)
    # Means of three by three pixels, at the border of those that there are.
    return uniform_filter(np.maximum(1 - share, 0), 3, mode="nearest")
