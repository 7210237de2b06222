"""The tongue put out between the lips."""

from __future__ import annotations

import numpy as np

from sculptor.assembly import build
from sculptor.implicit import Points

__all__ = ["put_out"]


def put_out(points: Points, amount: float) -> Points:
    """Points after the tongue has slid forwards over the lower teeth.

    Args:
        points: (V, 3) positions of the head's vertices.
        amount: 1 for all the way.
    """
    tongue = build().part == "tongue"
    rest = build().mesh.vertices[tongue]
    tip, root = rest[:, 2].max(), rest[:, 2].min()
    share = (rest[:, 2] - root) / (tip - root)
    out = points.copy()
    out[tongue, 0] *= 1.0 + 0.55 * amount * share**2
    out[tongue, 2] += amount * 3.9 * share**1.2
    out[tongue, 1] += amount * (0.72 * share**1.5 + 0.25 * np.sin(np.pi * share))  # over the teeth
    return out
