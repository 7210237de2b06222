"""What the formats of blend shapes share: names, in-betweens, curves as JSON, animations."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.rig import Rig
from elastomorph.rig.performance import HeadTurn

_MOST_TERMS = 256


def different_names(
    names: Iterable[str], *, first: int = 2, taken: Collection[str] = ()
) -> list[str]:
    """The names, with a number behind those that another has or are taken: ``smile_2``."""
    found: dict[str, None] = {}
    numbers: dict[str, int] = {}
    for name in names:
        free = name
        while free in found or free in taken:
            numbers[name] = numbers.get(name, first - 1) + 1
            free = f"{name}_{numbers[name]}"
        found[free] = None
    return list(found)


def hats(weights: NDArray[np.float64]) -> tuple[BendCurve, ...]:
    """For each in-between the curve that is 1 at its weight, 0 at the others and at 0 and 1.

    Between the weights, (n,) rising between 0 and 1, it is linear.
    """
    curves = []
    knots = np.concatenate([[0.0], weights, [1.0]])
    for before, peak, after in zip(knots, knots[1:], knots[2:], strict=False):
        breaks = np.unique([0.0, before, peak, after, 1.0])
        coefficients = np.zeros((len(breaks) - 1, 2))
        place = int(np.searchsorted(breaks, before))
        coefficients[place] = (0.0, 1 / (peak - before))
        coefficients[place + 1] = (1.0, -1 / (after - peak))
        curves.append(BendCurve(breaks, coefficients))
    return tuple(curves)


def curve_to_json(curve: BendCurve) -> dict[str, Any]:
    """A bend curve as plain lists; its numbers come back to the last bit."""
    return {"breaks": curve.breaks.tolist(), "coefficients": curve.coefficients.tolist()}


def curve_from_json(stored: Mapping[str, Any] | Any) -> BendCurve:
    """The bend curve in a file."""
    try:
        if len(stored["coefficients"][0]) > _MOST_TERMS:
            raise ValueError("too many coefficients a piece")
        return BendCurve(stored["breaks"], stored["coefficients"])
    except (TypeError, LookupError, ValueError, OverflowError):
        raise ParameterError("a bend curve is damaged") from None


def driven_weights(
    rig: Rig, times: ArrayLike, weights: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Times (T,) that rise, in seconds, and what slider weights (T, S) do to each morph, (T, J)."""
    table = rig.sliders.drive(rig.sliders.table(weights))
    try:
        seconds: NDArray[np.float64] = np.asarray(times, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError("the times of an animation must be numbers, in seconds") from None
    if seconds.shape != (len(table),) or not len(table):
        raise ParameterError(
            f"an animation needs one time for each of its {len(table)} rows of weights, found "
            f"times of shape {seconds.shape}"
        )
    if not np.isfinite(seconds).all() or (np.diff(seconds) <= 0).any():
        raise ParameterError(
            "the times of an animation must be finite seconds that rise from row to row"
        )
    return seconds, table


def require_turn(turn: HeadTurn | None, frames: int) -> None:
    """Refuse the turn of a head that does not belong to animations of so many frames in all."""
    if turn is not None and not (isinstance(turn, HeadTurn) and len(turn) == frames):
        raise ParameterError(
            f"a head is turned with an animation, by a HeadTurn of its {frames} frames"
        )
