"""Random bits that depend on a seed and on the number of a face, and on nothing else.

Face i owns the same stretch of the output of Philox-4x64 (Salmon et al., Parallel Random Numbers:
As Easy as 1, 2, 3, SC 2011) whoever asks for it. Only its raw words are used, for NumPy guarantees
those and not its distributions; each word is four *lanes* of 16 bits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

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
