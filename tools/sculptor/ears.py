"""The outer ear: loops from its root over the rim into the bowl."""

from __future__ import annotations

import numpy as np

from sculptor.anatomy import skin
from sculptor.implicit import Points, cast
from sculptor.layout import EAR

__all__ = ["ear_floor", "ear_rings"]

_CENTRE = (-1.75, -1.0)  # y, z
_TILT = np.radians(9.0)  # the top leans back
_HALF_SIZE = (1.65, 3.0)
_ROOT = (0.97, 0.76)  # sizes of loops 1 and 2, which lie on the head
# Loops 3 … 8: size, height over the rim, and height added where the rim is folded and at the
# small flap in front of the ear canal.
_PROFILE = (
    (0.86, -0.45, 0.00, 0.00),
    (1.00, -0.08, 0.00, 0.00),
    (0.94, 0.06, 0.14, 0.10),
    (0.83, -0.04, -0.36, 0.30),
    (0.66, -0.10, 0.14, 0.40),
    (0.48, -0.80, 0.00, -0.10),
)


def _contour() -> tuple[Points, Points]:
    count = len(EAR.outline())
    angle = np.radians(128.0 - 360.0 * np.arange(count) / count)
    up = np.sin(angle)
    back = np.cos(angle)
    back = np.where(back > 0.0, back * (1.0 + 0.28 * up), 0.82 * back)
    back = back - 0.10 * np.clip(-up, 0.0, None) ** 2 + 0.04 * up
    return back * _HALF_SIZE[0], up * _HALF_SIZE[1]


def _on_head(back: Points, up: Points) -> Points:
    """Points of the head's side at ear coordinates."""
    y = _CENTRE[0] + up * np.cos(_TILT) - back * np.sin(_TILT)
    z = _CENTRE[1] - up * np.sin(_TILT) - back * np.cos(_TILT)
    start = np.stack([np.full_like(y, 11.0), y, z], axis=1)
    return cast(skin, start, start * [0.0, 1.0, 1.0])


def ear_rings() -> Points:
    """The loops from the root to the bowl.

    Returns:
        (8, 26, 3) for the left ear: rings 1 … 8 of the layout.
    """
    back, up = _contour()
    shift = -0.25 * _HALF_SIZE[0]  # small loops sit to the front, where the ear is attached
    sizes = np.array([*_ROOT, *(entry[0] for entry in _PROFILE)])[:, None]
    across, along = sizes * back + (1.0 - sizes) * shift, sizes * up
    rings = _on_head(across.ravel(), along.ravel()).reshape(*across.shape, 3)
    rim, fold, flap = _rim(back, up)
    scale = np.clip(rim / 0.8, 0.25, 1.0)
    for ring, (_, height, folded, at_flap) in zip(rings[len(_ROOT) :], _PROFILE, strict=True):
        ring[:, 0] = _base(ring) + rim + (height + folded * fold) * scale + at_flap * flap
        ring[:, 2] -= 0.5 * max(at_flap, 0.0) * flap
    return rings


def _rim(back: Points, up: Points) -> tuple[Points, Points, Points]:
    """How far the rim stands off the head, and where it is folded and has its flap (0 … 1)."""
    b, u = back / _HALF_SIZE[0], up / _HALF_SIZE[1]
    share = np.clip(0.5 + 0.5 * b, 0.0, 1.0)
    swell = share**0.8 * (3.0 - 2.0 * share) / 1.0
    height = 0.25 + 0.92 * np.minimum(swell, 1.0) * (1.0 - 0.45 * np.clip(-u, 0, 1) ** 2)
    height *= 1.0 - 0.30 * np.clip(u, 0.0, 1.0) ** 4
    height *= 1.0 - 0.55 * np.clip(-u, 0.0, 1.0) ** 6
    fold = np.clip((u + 0.85) / 0.7, 0.0, 1.0) * np.clip(1.0 + (u + 0.1) * (b < 0), 0.0, 1.0)
    flap = np.exp(-(((u + 0.12) / 0.22) ** 2)) * (b < 0.0)
    return height, fold, flap


def _base(points: Points) -> Points:
    """x of the plane that the ear stands on: the head's side, evened out."""
    plane = np.c_[np.ones(len(points)), points[:, 1:]]
    coefficients = np.linalg.lstsq(plane, points[:, 0], rcond=None)[0]
    base: Points = plane @ coefficients
    return base


def ear_floor(rim: Points) -> Points:
    """The bowl inside the last ring.

    Args:
        rim: (rows, columns, 3) with the outline filled in.

    Returns:
        The same with its inside filled, sunk towards the ear canal.
    """
    floor = rim.copy()
    rows, columns = floor.shape[:2]
    floor[1:-1, 1:-1] = np.concatenate([rim[0], rim[-1]]).mean(axis=0)
    for _ in range(60):
        floor[1:-1, 1:-1] = 0.25 * (
            floor[:-2, 1:-1] + floor[2:, 1:-1] + floor[1:-1, :-2] + floor[1:-1, 2:]
        )
    r = np.linspace(-1.0, 1.0, rows)[:, None]
    c = np.linspace(-1.0, 1.0, columns)
    floor[..., 0] -= 0.35 * (1.0 - r**2) * (1.0 - c**2)
    return floor
