"""Free timing: every captured frame picks its own best moment of a path, in order.

What is left of an error at these moments is the fault of the path; what vanishes was timing.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.morph import Morph

__all__ = ["free_timing"]

_GRID = 2001
# Each round looks two spacings to either side in steps of an eighth: in a chain of ordered convex
# problems the exact optimum lies within one spacing of the best on the grid.
_ZOOM = 2.0 * np.linspace(-1.0, 1.0, 33)
_ZOOM_STEP = 1 / 8
_ROUNDS = 13


def free_timing(
    morph: Morph, frames: NDArray[np.float64], vertices: NDArray[np.integer]
) -> NDArray[np.float64]:
    """The non-decreasing times t′ at which a path comes closest to captured frames.

    Minimises the mean over frames and vertices of ‖V(t′_i) - Y_i‖² with
    0 = t′_0 ≤ t′_1 ≤ … ≤ t′_{T-1} = 1. The first frame is the neutral and the last the target, so
    they stay. A dynamic program finds the best on a dense grid, globally; the same program on ever
    finer grids around it then moves the times to rounding accuracy.

    In the plane of Δ and the bends, spanned by an orthonormal basis, a frame and the path are a
    handful of numbers, and the distance left out is the same for every t′. The small differences
    are therefore computed directly and not as the difference of large squares.

    Args:
        morph: The path.
        frames: (T, V, 3) captured vertices, T ≥ 2.
        vertices: (N,) indices of the vertices that count; one that is named twice counts twice.

    Returns:
        (T,) float64 from 0 to 1. Where the path stands still any t′ is as good as another.
    """
    times = np.linspace(0.0, 1.0, len(frames))
    if len(frames) == 2:
        return times
    fields = np.concatenate([morph.delta[None, vertices], morph.bends[:, vertices]])
    basis, weights = np.linalg.qr(fields.reshape(len(fields), -1).T)
    start = morph.neutral.vertices[vertices]
    wanted = np.stack([(frame[vertices] - start).ravel() @ basis for frame in frames[1:-1]])

    def costs(moments: NDArray[np.float64]) -> NDArray[np.float64]:
        """(T - 2, G) squared distance of each inner frame from the path at (1 or T - 2, G)."""
        path = _curves(morph, moments) @ weights.T
        total = np.zeros((len(wanted), moments.shape[1]))
        for axis in range(path.shape[2]):
            total += (path[:, :, axis] - wanted[:, None, axis]) ** 2
        return total

    spacing = 1.0 / (_GRID - 1)
    grid = np.linspace(0.0, 1.0, _GRID)[None]
    inner = best_in_order(np.broadcast_to(grid, (len(wanted), _GRID)), costs(grid))
    for _ in range(_ROUNDS):
        moments = np.clip(inner[:, None] + spacing * _ZOOM, 0.0, 1.0)
        inner = best_in_order(moments, costs(moments))
        spacing *= _ZOOM_STEP
    times[1:-1] = inner
    return times


def best_in_order(moments: NDArray[np.float64], costs: NDArray[np.float64]) -> NDArray[np.float64]:
    """One moment a frame, never falling from frame to frame, of least total cost.

    Args:
        moments: (T, G) moments to choose from, rising along each row.
        costs: (T, G) cost of each.

    Returns:
        (T,) the moments chosen.
    """
    count, size = costs.shape
    columns = np.arange(size)
    came_from = np.zeros((count, size), dtype=np.int32)
    total = costs[0]
    for frame in range(1, count):
        cheapest = np.minimum.accumulate(total)
        where = np.maximum.accumulate(np.where(total == cheapest, columns, 0))
        before = np.searchsorted(moments[frame - 1], moments[frame], side="right") - 1
        reachable = before >= 0
        came_from[frame] = where[before]
        total = np.where(reachable, costs[frame] + cheapest[before], np.inf)
    chosen = np.empty(count, dtype=np.int64)
    chosen[-1] = int(total.argmin())
    for frame in range(count - 1, 0, -1):
        chosen[frame - 1] = came_from[frame, chosen[frame]]
    return moments[np.arange(count), chosen]


def _curves(morph: Morph, moments: NDArray[np.float64]) -> NDArray[np.float64]:
    """(…, 1 + K) the weights t, b_1(t), …, b_K(t) of Δ and the bends."""
    return np.stack([moments, *(curve(moments) for curve in morph.bend_curves)], axis=-1)
