"""A performance on a rig."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import DTypeLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.rig import Rig
from elastomorph.rig.performance.matching import Match, match
from elastomorph.rig.performance.performance import Performance

__all__ = ["play", "slider_weights"]


def slider_weights(
    rig: Rig, performance: Performance, by: Match | None = None, *, clip: bool = False
) -> NDArray[np.float64]:
    """(T, J) weights of the rig's sliders in each frame.

    Args:
        rig: The rig.
        performance: The recorded weights.
        by: Which weights drive which sliders; found by name where it is left out.
        clip: Keep the weights within 0 and 1. Otherwise a path goes on along its tangent.

    Raises:
        ParameterError: The match belongs to another recording or rig, or names are not clear.
    """
    own = match(performance.names, rig.names) if by is None else by
    if own.weights != performance.names or own.sliders != rig.names:
        raise ParameterError(
            "the match belongs to another recording or rig; make it with "
            "match(performance.names, rig.names)"
        )
    driven = own.drive(performance.weights)
    return np.clip(driven, 0.0, 1.0) if clip else driven


def play(
    rig: Rig,
    performance: Performance,
    by: Match | None = None,
    *,
    clip: bool = False,
    dtype: DTypeLike = np.float32,
    block: int | None = None,
) -> Iterator[NDArray[np.floating]]:
    """The frames of a performance, one face at a time, in fixed memory.

    Args:
        rig: The rig.
        performance: The recorded weights; resample it first for an even rate.
        by: Which weights drive which sliders; found by name where it is left out.
        clip: Keep the weights within 0 and 1.
        dtype: float32 or float64.
        block: Faces computed at once, as for `Rig.stream`.

    Yields:
        (V, 3) arrays that later ones overwrite, so copy what you keep.

    Raises:
        ParameterError: As `slider_weights`; as `Rig.stream`.
    """
    weights = slider_weights(rig, performance, by, clip=clip)
    for faces in rig.stream(weights, dtype=dtype, block=block):
        yield from faces
