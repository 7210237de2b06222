"""Laws of chance of one number, each a table: what stands for each of the 65,536 lanes.

A number that is stored in 16 bits is drawn by one look into a table, whatever its law.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.columns import LEVELS, Codes, Column, Columns

Floats = NDArray[np.float64]


def quantiles() -> Floats:
    """(65536,) what each lane stands for between 0 and 1: the middles of as many equal parts."""
    return np.asarray((np.arange(LEVELS + 1) + 0.5) / (LEVELS + 1))


def sizes(rest: int, power: float) -> Codes:
    """Codes of a slider that rests at a code, by how far it is on; lane 0 is off.

    The distance from rest is u^power of the way to the end of the range, u uniform; a range on both
    sides of 0 has on each side as many as it is long.
    """
    code = np.arange(LEVELS + 1)
    longest = np.where(code < rest, rest, LEVELS - rest)
    way = np.abs(code - rest) / np.maximum(longest, 1)
    moved = np.rint(way**power * longest) * np.sign(code - rest)
    table = (rest + moved).astype(np.uint16)
    table[0] = rest
    return table


def codes_of(column: Column, values: Floats) -> Codes:
    """(65536,) codes of values of a column."""
    return Columns((column,)).encode(values[:, None])[:, 0]


def normal(low: float, high: float, mean: float, deviation: float) -> Floats:
    """(65536,) quantiles of the normal law that is cut off at low and high."""
    from scipy.special import ndtr, ndtri

    if not low <= mean <= high:
        raise ParameterError(f"the mean must be from {low:g} to {high:g}, found {mean:g}")
    below, above = ndtr((np.array([low, high]) - mean) / deviation)
    values = mean + deviation * ndtri(below + (above - below) * quantiles())
    return np.asarray(np.clip(values, low, high))


def gamma(shape: float) -> Floats:
    """(65536,) quantiles of the gamma law of a shape, of scale 1."""
    from scipy.special import gammaincinv

    return np.asarray(gammaincinv(shape, quantiles()))
