"""In which units a table of weights over time is: seconds or milliseconds, 1 or 100 in full.

A face is recorded at 5 to 250 frames a second, and a weight is rarely above 2. So times that are 4
to 250 apart are milliseconds, and weights of up to 100 or so are percent, unless there is too
little to tell by: then the file is refused. A column ``seconds`` in place of ``time`` says that all
numbers are as they should be, ``milliseconds`` that times are these.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["TIME_COLUMNS", "AmbiguousUnitsError", "Units", "units_of"]

_AS_IT_IS = "seconds"
_MILLISECONDS = ("milliseconds", "ms", "time_ms", "time (ms)", "time [ms]")
TIME_COLUMNS = ("time", _AS_IT_IS, *_MILLISECONDS)
"""What the column of times may be called, in small letters."""

_CLOSEST, _FARTHEST = 4.0, 250.0
_FEWEST_TIMES = 10
_MOST_IN_FULL = 2.0
_LEAST_PERCENT, _MOST_PERCENT = 10.0, 200.0
_FEWEST_IN_PERCENT = 0.25

# Turns and places of head and eyes may be in degrees or centimetres beside weights of 1.
_POSE = re.compile(r"(head|neck|eye).*(yaw|pitch|roll|rot\w*|pos\w*|trans\w*|[xyz])", re.IGNORECASE)


class AmbiguousUnitsError(ValueError):
    """Nothing tells which units numbers have; the sentence says how to tell."""


@dataclass(frozen=True, eq=False)
class Units:
    """What to multiply with.

    Attributes:
        time: For seconds.
        weights: (N,) for each column of weights.
        said: What was taken for what, if anything was guessed.
    """

    time: float
    weights: NDArray[np.float64]
    said: tuple[str, ...]


def units_of(
    column: str, names: Sequence[str], times: NDArray[np.float64], weights: NDArray[np.float64]
) -> Units:
    """The units of a table.

    Args:
        column: Name of the column of times.
        names: Names of the N columns of weights.
        times: (T,) as in the file.
        weights: (T, N) as in the file.

    Raises:
        AmbiguousUnitsError: They could be either.
    """
    unchanged = np.ones(len(names))
    if column.casefold() == _AS_IT_IS:
        return Units(1.0, unchanged, ())
    said = []
    time = 1.0
    if column.casefold() in _MILLISECONDS or _in_milliseconds(times):
        time = 1e-3
        said.append(f"the times in '{column}' are taken for milliseconds")
    scales = unchanged
    own = np.array([not _POSE.fullmatch(name) for name in names])
    if _in_percent(weights[:, own]):
        scales = np.where(own, 0.01, 1.0)
        said.append("the weights are taken for percent, 100 in full")
    return Units(time, scales, tuple(said))


def _in_milliseconds(times: NDArray[np.float64]) -> bool:
    step = float(np.median(np.diff(times))) if len(times) > 1 else 0.0
    if not _CLOSEST <= step <= _FARTHEST:
        return False
    if len(times) < _FEWEST_TIMES:
        raise AmbiguousUnitsError(
            f"the times are {step:g} apart, which could be seconds or milliseconds; call their "
            f"column '{_AS_IT_IS}' or '{_MILLISECONDS[0]}'"
        )
    return True


def _in_percent(weights: NDArray[np.float64]) -> bool:
    largest = np.abs(weights).max(axis=0, initial=0.0)
    most = float(largest.max(initial=0.0))
    if not _MOST_IN_FULL < most <= _MOST_PERCENT:
        return False
    moving = np.count_nonzero(largest)
    above = np.count_nonzero(largest > _MOST_IN_FULL)
    if most <= _LEAST_PERCENT or above < _FEWEST_IN_PERCENT * moving:
        raise AmbiguousUnitsError(
            f"the weights go up to {most:g}, which could be percent or not; scale them to 0 to 1, "
            f"or call the column of times '{_AS_IT_IS}' to have all numbers taken as they are"
        )
    return True
