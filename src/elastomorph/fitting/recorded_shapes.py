"""Bends that are recorded frames, and curves for them.

The bend of a frame is how far it is off the straight path, so that an artist can sculpt or clean
the scan it comes from. Which frames: those whose shapes, with the best splines for them, leave the
least sum of squares, found one after the other and then exchanged while that helps. All that is
needed of the vertices is the matrix of the products of frames.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.fitting.path_fit import Observed, Splines

__all__ = ["best_recorded"]

Floats = NDArray[np.float64]

_RIDGE = 1e-9


def best_recorded(seen: Observed, splines: Splines, count: int) -> list[int]:
    """So many frames whose offsets are the best shapes, in their order."""
    offsets = seen.offsets if seen.counted is None else seen.offsets * seen.counted[:, None]
    rows = offsets.reshape(len(offsets), -1)
    if seen.fixed is not None:
        rows = np.concatenate([rows, seen.fixed.reshape(1, -1)])
    products = rows @ rows.T
    basis = np.linalg.qr(splines.values)[0]
    told = basis.T @ products[: len(offsets)]
    always = [len(offsets)] if seen.fixed is not None else []

    def explained(frames: list[int]) -> float:
        own = always + frames
        grams = products[np.ix_(own, own)]
        grams = grams + _RIDGE * np.trace(grams) * np.eye(len(own))
        return float(np.einsum("mi,mi->", told[:, own], np.linalg.solve(grams, told[:, own].T).T))

    inner = range(1, len(offsets) - 1)
    chosen: list[int] = []
    for _ in range(count):
        chosen.append(max(set(inner) - set(chosen), key=lambda f: explained([*chosen, f])))
    known, better = explained(chosen), True
    while better:
        better = False
        for place in range(count):
            others = [f for k, f in enumerate(chosen) if k != place]
            best = max(set(inner) - set(others), key=lambda f: explained([*others, f]))
            if (found := explained([*others, best])) > known * (1 + 1e-12):
                chosen, known, better = [*others, best], found, True
    return sorted(chosen)
