"""Named poses on a rig: which sliders they mean, and a performance that goes through them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import first_few
from elastomorph.rig.naming import is_rotation, nearest_name
from elastomorph.rig.performance.matching import match
from elastomorph.rig.performance.performance import Performance
from elastomorph.rig.timing import Timing, smoothstep

Poses = Mapping[str, Mapping[str, float]]

_SHOWN = 8
_MOST_FRAMES = 1_000_000
_SAME = 1e-6
"""Of a frame: closer to a pose, a frame is that pose."""


class FittedPoses(NamedTuple):
    """Poses by the names of a rig's sliders, and what none of its sliders stands for."""

    poses: dict[str, dict[str, float]]
    unknown: tuple[str, ...]


def fitted_poses(poses: Poses, sliders: Sequence[str]) -> FittedPoses:
    """Poses for a rig: names that it has are its own, others are matched as those of a take.

    Args:
        poses: The weight of each slider by name, of each pose by name.
        sliders: Names on the rig.

    Raises:
        ParameterError: It is not clear which slider a name means, see `match`.
    """
    names, table = _table(poses)
    if set(names) <= set(sliders):
        return FittedPoses({name: dict(own) for name, own in poses.items()}, ())
    found = match(names, sliders)
    rows = found.drive(table).tolist()
    driven = [
        {slider: weight for slider, weight in zip(found.sliders, row, strict=True) if weight}
        for row in rows
    ]
    unknown = (*found.unmatched_weights, *filter(is_rotation, names))
    return FittedPoses(dict(zip(poses, driven, strict=True)), unknown)


def unknown_sliders(unknown: Sequence[str], sliders: Sequence[str]) -> str:
    """A sentence about names that a rig does not have, with the nearest that it has."""
    words = []
    for name in unknown[:_SHOWN]:
        near = nearest_name(name, sliders)
        words.append(f"{name!r} (did you mean {near!r}?)" if near else repr(name))
    return f"the rig has no slider {first_few([*words, *unknown[_SHOWN:]], _SHOWN)}"


def through_poses(
    poses: Poses,
    times: Sequence[float] | None = None,
    *,
    timing: Timing = smoothstep,
    rate: float = 30.0,
    source: str = "",
) -> Performance:
    """A performance that is in each pose at its time, and between two as the timing says.

    Args:
        poses: The weight of each slider by name, of each pose by name, in order.
        times: Seconds of each pose, rising; a second from one to the next by default.
        timing: How far the way from one pose to the next has come, from 0 to 1.
        rate: Frames a second. Each pose is a frame too, wherever its time lies.
        source: Where the poses come from.

    Raises:
        ParameterError: No pose, other times than poses, times that do not rise, or a timing that
            does not lead from 0 to 1.
    """
    names, table = _table(poses)
    when = np.arange(len(table), dtype=np.float64) if times is None else np.array(times, float)
    if not len(table) or when.shape != (len(table),):
        raise ParameterError(f"{len(table)} poses need a time each, found {len(when)}")
    if not np.isfinite(when).all() or (np.diff(when) <= 0).any():
        raise ParameterError(
            f"the times of poses must rise, found {', '.join(f'{t:g}' for t in when)}"
        )
    if not rate > 0 or not np.isfinite(rate):
        raise ParameterError(f"the rate must be frames a second above 0, found {rate}")
    if not np.allclose(timing.at([0.0, 1.0]), [0.0, 1.0]):
        raise ParameterError(
            f"the timing {timing.name} does not lead from one pose to the next; take smoothstep, "
            "minimum-jerk, cosine, linear or keys from 0=0 to 1=1"
        )
    frames = _moments(when, rate)
    before = np.clip(np.searchsorted(when, frames, side="right") - 1, 0, max(len(when) - 2, 0))
    after = np.minimum(before + 1, len(when) - 1)
    length = np.where(after > before, when[after] - when[before], 1.0)
    way = timing.at((frames - when[before]) / length)[:, None]
    weights = table[before] * (1 - way) + table[after] * way
    return Performance(names, frames, weights, rate, source=source)


def _moments(when: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """(T,) frames at an even rate from the first time on, and the times themselves."""
    places = (when - when[0]) * rate
    if places[-1] > _MOST_FRAMES:
        raise ParameterError(
            f"{rate:g} frames a second of {when[-1] - when[0]:g} s are more than "
            f"{_MOST_FRAMES:,} frames; choose a lower rate"
        )
    even = np.arange(int(places[-1]) + 1)
    beside = np.rint(places[np.abs(places - np.rint(places)) < _SAME]).astype(np.int64)
    return np.union1d(when[0] + np.setdiff1d(even, beside) / rate, when)


def _table(poses: Poses) -> tuple[list[str], NDArray[np.float64]]:
    """The names of all weights, and (poses, names) weights."""
    names = list(dict.fromkeys(name for weights in poses.values() for name in weights))
    rows = [[float(weights.get(name, 0.0)) for name in names] for weights in poses.values()]
    return names, np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
