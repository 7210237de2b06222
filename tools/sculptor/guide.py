"""Where the grid of the layout lies on the head: rays through the skin, row by row."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from sculptor.implicit import Points
from sculptor.layout import COLUMNS, ROWS

__all__ = ["rays"]

# Front height of each row, crown to neck; rows crowd where the profile folds.
_FRONT_Y = (
    10.2, 9.2, 8.1, 7.0, 6.0, 5.0, 4.1, 3.3, 2.5, 1.45, 0.4, -0.65, -1.7, -2.4, -3.0, -3.45,
    -3.85, -4.2, -4.5, -4.75, -4.92, -5.07, -5.5, -6.25, -7.0, -7.75, -8.5, -9.1, -9.75, -10.4,
    -11.0, -11.45, -11.75, -12.0, -12.2, -12.8, -13.6, -14.5, -15.6, -16.7, -18.0,
)  # fmt: skip

# row: front z; side x, y, z; back y, z; pitch of the rays at front, side, back
_KEYS = {
    0: (4.8, 5.6, 10.0, -0.9, 9.4, -6.2, 6.0, 6.0, 6.0),
    4: (8.6, 7.2, 7.2, -0.9, 5.4, -9.3, 2.0, 2.0, 1.5),
    8: (9.6, 7.5, 2.6, -0.7, 1.2, -9.7, 0.0, 0.0, 0.0),
    12: (9.4, 7.0, -1.2, -0.2, -2.3, -9.0, 0.0, 0.0, 0.0),
    17: (11.0, 6.6, -5.0, -0.2, -5.4, -7.6, 0.0, 0.0, 0.0),
    22: (10.0, 6.2, -6.5, 0.0, -7.0, -7.2, 0.0, 0.0, 0.0),
    26: (9.6, 5.9, -7.9, 0.0, -8.8, -7.0, 0.0, -0.5, 0.0),
    30: (9.2, 5.5, -9.4, -0.6, -10.6, -7.0, -2.0, -1.0, 0.0),
    32: (7.6, 5.4, -10.4, -1.2, -11.6, -7.0, -5.0, -1.0, 0.0),
    34: (4.8, 5.3, -11.7, -1.8, -12.6, -7.1, -5.0, -1.0, 0.0),
    36: (3.4, 5.3, -13.4, -2.2, -13.8, -7.4, -1.0, 0.0, 0.0),
    40: (2.4, 6.0, -17.8, -3.0, -17.0, -8.6, 0.0, 0.0, 0.0),
}

# row: x of the columns 0 … 13 in front
_FRONT_X = {
    0: (0, 0.45, 0.9, 1.35, 1.8, 2.25, 2.7, 3.1, 3.5, 3.85, 4.2, 4.5, 4.75, 4.95),
    4: (0, 0.45, 0.9, 1.35, 1.8, 2.3, 2.8, 3.3, 3.8, 4.3, 4.8, 5.25, 5.65, 6.0),
    8: (0, 0.3, 0.6, 0.9, 1.2, 1.7, 2.25, 2.8, 3.35, 3.9, 4.45, 5.0, 5.5, 5.95),
    12: (0, 0.3, 0.6, 0.87, 1.15, 1.65, 2.2, 2.75, 3.3, 3.85, 4.4, 4.9, 5.35, 5.75),
    15: (0, 0.36, 0.72, 1.06, 1.42, 1.82, 2.35, 2.85, 3.4, 3.9, 4.4, 4.9, 5.3, 5.65),
    18: (0, 0.4, 0.82, 1.25, 1.62, 1.9, 2.38, 2.88, 3.4, 3.9, 4.4, 4.85, 5.25, 5.6),
    22: (0, 0.5, 1.0, 1.5, 2.02, 2.54, 3.04, 3.5, 3.9, 4.25, 4.6, 4.92, 5.2, 5.47),
    26: (0, 0.48, 0.96, 1.44, 1.94, 2.44, 2.92, 3.38, 3.75, 4.05, 4.32, 4.58, 4.8, 5.02),
    30: (0, 0.42, 0.84, 1.26, 1.68, 2.1, 2.5, 2.9, 3.25, 3.6, 3.9, 4.2, 4.45, 4.65),
    40: (0, 0.45, 0.9, 1.35, 1.8, 2.25, 2.7, 3.1, 3.5, 3.9, 4.3, 4.65, 5.0, 5.3),
}


def _by_row(table: Mapping[int, tuple[float, ...]]) -> NDArray[np.float64]:
    """The columns of a table of key rows, for every row: cubic Hermite curves through the keys."""
    keys = np.array(list(table), dtype=float)
    values = np.array(list(table.values()), dtype=float)
    slopes = np.gradient(values, keys, axis=0)
    rows = np.arange(ROWS + 1.0)
    left = np.clip(np.searchsorted(keys, rows, side="right") - 1, 0, len(keys) - 2)
    width = (keys[left + 1] - keys[left])[:, None]
    t = (rows - keys[left])[:, None] / width
    start, end = values[left], values[left + 1]
    bend = start + (end - start) * t**2 * (3.0 - 2.0 * t)
    lean = slopes[left] * (1.0 - t) - slopes[left + 1] * t
    curves: NDArray[np.float64] = bend + width * t * (1.0 - t) * lean
    return curves


def rays() -> tuple[Points, Points]:
    """For each grid vertex, a point outside the head and one inside it.

    Returns:
        Two arrays (ROWS + 1, COLUMNS + 1, 3).
    """
    keys = _by_row(_KEYS)
    front_x = _by_row(_FRONT_X)
    front_y = np.array(_FRONT_Y)[:, None]
    front_z, side_x, side_y, side_z, back_y, back_z, *pitch = (keys[:, [k]] for k in range(9))
    last = front_x.shape[1] - 1
    angle = np.empty((ROWS + 1, COLUMNS + 1))
    angle[:, : last + 1] = np.arcsin(np.minimum(front_x / side_x, 0.999))
    share = np.linspace(0.0, 1.0, COLUMNS - last + 1)
    angle[:, last:] = angle[:, [last]] + share * (np.pi - angle[:, [last]])
    sine, cosine = np.sin(angle), np.cos(angle)
    ahead = angle <= np.pi / 2
    end_y = np.where(ahead, front_y, back_y)
    end_z = np.where(ahead, front_z, back_z)
    end_pitch = np.where(ahead, pitch[0], pitch[2])
    side = sine**2
    x = side_x * sine
    y = end_y + (side_y - end_y) * side
    z = side_z + (end_z - side_z) * np.abs(cosine)
    lean = end_pitch + (pitch[1] - end_pitch) * side
    parallel = np.where(ahead, cosine**2, 0.0)  # in front the rays run along z
    inner = np.stack([x * parallel, y - lean, np.full_like(x, -0.6)], axis=2)
    guide = np.stack([x, y, z], axis=2)
    outward = guide - inner
    outward /= np.linalg.norm(outward, axis=2, keepdims=True)
    return guide + 6.0 * outward, inner
