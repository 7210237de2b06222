"""From what a user asks of a rig to the weight ζ and the time t of each of its morphs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import as_number, as_numbers
from elastomorph.rig.sliders import Sliders, Weights

__all__ = ["Times", "Weights", "named_moments", "table_moments"]

Times = float | Mapping[str, float]

# Weights whose sum is this small a part of them cancel; what is left is rounding.
_NOISE = 1e-12


def named_moments(
    sliders: Sliders, weights: Weights, t: Times, normalize: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(morphs,) ζ and times of one face, from what a caller of `Rig.blend` gave."""
    row = sliders.row(weights)[None]
    moments = np.ones((1, len(sliders.names)))
    if isinstance(t, Mapping):
        given = sliders.row(t)
        chosen = [name in t for name in sliders.names]
        moments[0, chosen] = given[chosen]
    else:
        moments[:] = as_number(t, "the time")
    zeta = _normalized(row) if normalize else row
    return sliders.drive(zeta)[0], sliders.spread(moments)[0]


def table_moments(
    sliders: Sliders, weights: ArrayLike, times: ArrayLike | None, normalize: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(S, morphs) ζ and times of many faces, from what a caller of `Rig.batch` gave."""
    table = sliders.table(weights)
    if times is None:
        driven = sliders.drive(table)
        return (driven != 0).astype(float), driven
    moments = as_numbers(times, "times")
    if moments.shape == (len(table),):
        moments = moments[:, None]
    elif moments.shape not in ((), table.shape):
        raise ParameterError(
            f"times must be one number, ({len(table)},) or {table.shape}, found {moments.shape}"
        )
    moments = sliders.table(np.broadcast_to(moments, table.shape), "times")
    zeta = _normalized(table) if normalize else table
    return sliders.drive(zeta), sliders.spread(moments)


def _normalized(weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """Each row over its sum.

    Raises:
        ParameterError: A sum is zero, or nothing but rounding.
    """
    total = weights.sum(axis=1, keepdims=True)
    none = np.abs(total) <= _NOISE * np.abs(weights).sum(axis=1, keepdims=True)
    if none.any():
        where = f" of face {int(np.argmax(none))}" if len(weights) > 1 else ""
        raise ParameterError(
            f"the weights{where} sum to 0, so they cannot be divided by their sum: leave "
            "normalize out, or give weights whose sum is not 0"
        )
    return np.asarray(weights / total)
