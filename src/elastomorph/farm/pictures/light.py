"""What light reaches points of a surface: shadows of the lamp, and hollows that are dark."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.farm.pictures.view import Points, View

__all__ = ["hollows", "shadows"]

Shares = NDArray[np.float32]

_LAMP, _RIM = 0.06, 3
"""Radius of the lamp over its distance, and how many places of its rim are asked."""
_LIFT, _LIFT_TURNED = 0.003, 0.05  # of D
_DARK = -0.35
"""Cosine below which no light comes round the edge of what is lit, see `shading`."""
_REACH = 0.11
"""How far hollows are felt, in D: mouth, nostrils and the corners of the eyes are dark."""
_DIRECTIONS = 16
_DARKNESS, _LEVEL = 1.1, 0.02


def shadows(view: View, points: Points, extent: float) -> Shares:
    """(N,) how much of the lamp each point sees, from 0 to 1; the extent is D.

    Rays go to the middle of the lamp and to its rim. They start a little off the surface, farther
    where it is turned from the lamp, for smooth normals reach beyond the polygons they are of.
    """
    lamp = view.scene.lamp
    across = np.cross(lamp, [0.0, 1.0, 0.0] if abs(lamp[1]) < 0.9 else [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    along = np.cross(lamp, across)
    facing = points.normal @ lamp.astype(np.float32)
    lifted = _LIFT + _LIFT_TURNED * np.clip(0.3 - facing, 0, 0.6)
    start = points.position + points.normal * (extent * lifted)[:, None]
    asked = np.flatnonzero(facing > _DARK)
    seen = np.zeros(len(facing), dtype=np.float32)
    turns = np.arange(_RIM) * 2 * np.pi / _RIM
    rim = [_LAMP * (np.cos(turn) * across + np.sin(turn) * along) for turn in turns]
    for aside in [np.zeros(3), *rim]:
        ways = np.broadcast_to(lamp + aside, (len(asked), 3))
        seen[asked] += view.solid.free(start[asked], ways)
    return seen / np.float32(_RIM + 1)


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
    # Turns by the golden angle, evenly spread in the disc.
    for step in range(_DIRECTIONS):
        radius = reach * np.sqrt((step + 0.5) / _DIRECTIONS)
        angle = step * np.pi * (3 - np.sqrt(5))
        x, y = (reach + round(float(radius * turn(angle))) for turn in (np.cos, np.sin))
        way = padded[y : y + height, x : x + width] - position
        squared = np.einsum("hwk,hwk->hw", way, way)
        above = np.einsum("hwk,hwk->hw", way, normal) - np.float32(0.004 * extent)
        taken += np.maximum(above, 0) / (squared + least)
    share = taken * np.float32(_DARKNESS * 2 * _REACH * extent / _DIRECTIONS)
    return _blurred(np.maximum(1 - share, 0))


def _blurred(values: Shares) -> Shares:
    """Means of three by three pixels, at the border of those that there are."""
    padded = np.pad(values, 1, mode="edge")
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    return np.asarray((rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]) / np.float32(9))
