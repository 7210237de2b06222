"""Random bits that depend on a seed and on the number of a face, and on nothing else.

Face i owns the same stretch of the output of Philox-4x64 (Salmon et al., Parallel Random Numbers:
As Easy as 1, 2, 3, SC 2011) whoever asks for it. Only its raw words are used, for NumPy guarantees
those and not its distributions; each word is four *lanes* of 16 bits. A law of chance is a table of
what stands for each of the 65,536 lanes: a number that is stored in 16 bits is drawn by one look
into it, whatever its law.
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


Lanes = NDArray[np.uint16]

_IN_BLOCK = 16
"""Lanes of one step of the counter: four words of 64 bits."""

_KEY = 0x656C6173746F
"""The second half of the key, so that this is the stream of no other program with our seed."""


def stride_of(lanes: int) -> int:
    """Lanes that a face owns where so many are used: whole steps of the counter."""
    return -(-max(lanes, 1) // _IN_BLOCK) * _IN_BLOCK


def random_lanes(seed: int, start: int, stop: int, stride: int) -> Lanes:
    """(stop - start, stride) uint16: uniform and independent."""
    steps = stride // _IN_BLOCK
    counter = start * steps
    words = np.random.Philox(
        key=np.array([seed, _KEY], dtype=np.uint64),
        counter=np.array([counter & (2**64 - 1), counter >> 64, 0, 0], dtype=np.uint64),
    ).random_raw((stop - start) * steps * 4)
    return words.astype("<u8", copy=False).view("<u2").reshape(stop - start, stride)


def whole_numbers(lanes: Lanes) -> NDArray[np.uint64]:
    """(n,) numbers below 2³² from (n, 2) lanes."""
    return lanes[:, 0].astype(np.uint64) << np.uint64(16) | lanes[:, 1]


def below(lanes: Lanes, count: int) -> NDArray[np.int64]:
    """(n,) whole numbers from 0 to count - 1, with count at most 2³¹, from (n, 2) lanes."""
    return (whole_numbers(lanes) * np.uint64(count) >> np.uint64(32)).astype(np.int64)
