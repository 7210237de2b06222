"""Numbers as users give them, not as NumPy would take them; and what is said of what was found."""

from __future__ import annotations

from collections.abc import Iterable
from numbers import Real
from typing import TypeGuard

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from elastomorph.errors import ParameterError

LARGEST_WEIGHT = 1000.0
"""Of weights and times, 0 to 1 of faces: percentages pass, an exponent typed wrongly does not."""
_LONGEST = 60


def as_numbers(values: ArrayLike, what: str, *, switches: bool = False) -> NDArray[np.float64]:
    """Numbers as float64, C-contiguous, of any shape; the array itself where it is that already.

    NumPy takes None for a NaN, True for 1 and the text "1" for a number; nobody means that. With
    `switches` True and False are meant, as 1 and 0.
    """
    try:
        given = np.asarray(values)
    except (TypeError, ValueError):
        given = np.empty((), dtype=np.str_)
    mixed = given.dtype.kind == "O" and all(_is_number(value) for value in given.flat)
    if given.dtype.kind not in ("biuf" if switches else "iuf") and not mixed:
        raise ParameterError(f"{what} must be numbers, found {shown(values)}")
    return given.astype(np.float64, order="C", copy=False)


def path_times(times: ArrayLike) -> NDArray[np.float64]:
    """Times of paths, of any shape: as `as_numbers`, within ± `LARGEST_WEIGHT`."""
    moments = as_numbers(times, "times")
    far = ~(np.abs(moments) <= LARGEST_WEIGHT)
    if far.any():
        raise ParameterError(
            f"times of a path are about 0 to 1, at most {LARGEST_WEIGHT:g}, found "
            f"{moments[far][0]:g}"
        )
    return moments


def as_number(
    value: object, what: str, *, above: float | None = None, least: float | None = None
) -> float:
    """One finite number as a float, above a bound or not less than the least allowed."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    number = float(value) if isinstance(value, Real) and _is_number(value) else np.nan
    low = (above is not None and number <= above) or (least is not None and number < least)
    if low or not np.isfinite(number):
        bound = f" above {above:g}" if above is not None else ""
        bound += f" ≥ {least:g}" if least is not None else ""
        kind = "finite number" if np.isinf(number) else "number"
        raise ParameterError(f"{what} must be a {kind}{bound}, found {value!r}")
    return number


def is_whole(value: object) -> TypeGuard[int]:
    """Whether it is a whole number, Python's or NumPy's; True and False are none."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def real_type(dtype: DTypeLike) -> np.dtype[np.floating]:
    """float32 or float64, as a caller names it."""
    for real in (np.dtype(np.float32), np.dtype(np.float64)):
        try:
            if np.dtype(dtype) == real:
                return real
        except TypeError:
            break
    raise ParameterError(f"faces are float32 or float64, not {dtype}")


def power_of_two(most: int) -> int:
    """The largest power of two that is no more than a number; 1 where none is."""
    return 1 << max(most, 1).bit_length() - 1


def shown(value: object) -> str:
    """What was found, for a message: it itself where that is short, else of what type it is."""
    text = repr(value)
    return text if len(text) <= _LONGEST and "\n" not in text else type(value).__name__


def first_few(names: Iterable[object], most: int) -> str:
    """Names for a message, the first of many: "a, b and 7 more"."""
    kept = list(names)
    rest = len(kept) - most
    return ", ".join(map(str, kept[:most])) + (f" and {rest:,} more" if rest > 0 else "")


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)
