"""The frames of a motion through which a path comes closest to all of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import combinations
from math import comb, inf
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from elastomorph.evaluation.spline_errors import Choice

__all__ = ["EFFORT", "Judge", "best_frames"]

EFFORT = 20_000_000.0
"""How many choices times frames are compared at once, unless told: seconds on one core."""


class Judge(Protocol):
    """A measure of error that can compare many choices of frames."""

    @property
    def times(self) -> NDArray[np.float64]:
        """(T,) times of the frames."""

    def best(self, choices: NDArray[np.int64], known: Choice) -> Choice:
        """The best of (S, n) choices, or ``known`` where none is better."""


def best_frames(
    judge: Judge,
    count: int,
    *,
    effort: float = EFFORT,
    progress: Callable[[str], None] = lambda _: None,
) -> list[Choice]:
    """The best choice of n frames for n = 1 … count.

    All choices are compared where that is affordable. Else all choices among every second, third
    … frame are, and the best of them is improved by moving all its frames a little and by
    exchanging one of them for any other while that helps.

    Args:
        judge: The measure of error.
        count: Most frames to choose, at most T - 2.
        effort: Choices times T that may be compared at once; infinite to compare all choices.
        progress: Called with a few words before each n.

    Returns:
        One choice for each n.
    """
    total = len(judge.times)
    found: list[Choice] = []
    frames: tuple[int, ...] = ()
    for size in range(1, count + 1):
        progress(f"choosing {size} of {total - 2} frames")
        added = [(*frames, new) for new in range(1, total - 1) if new not in frames]
        best = _improved(judge, judge.best(_sorted(added, size), Choice((), inf)), effort)
        step = next(
            step
            for step in range(1, total + 1)
            if size == 1 or comb(len(range(1, total - 1, step)), size) * total <= effort
        )
        choices = _sorted(list(combinations(range(1, total - 1, step), size)), size)
        better = judge.best(choices, best)
        if step > 1 and better is not best:
            better = _improved(judge, better, effort)
        found.append(replace(better, certain=step == 1))
        frames = better.frames
    return found


def _improved(judge: Judge, choice: Choice, effort: float) -> Choice:
    """A choice that neither small moves of all frames nor any exchange of one makes better."""
    total = len(judge.times)
    reach = 0
    while (2 * reach + 3) ** len(choice.frames) * total <= effort / 20 and reach < total:
        reach += 1
    while True:
        better = judge.best(_exchanged(choice.frames, total), choice)
        better = judge.best(_moved(better.frames, reach, total), better)
        if better is choice:
            return choice
        choice = better


def _exchanged(frames: tuple[int, ...], total: int) -> NDArray[np.int64]:
    """All choices in which one frame is another."""
    others = [frame for frame in range(1, total - 1) if frame not in frames]
    return _sorted(
        [(*frames[:i], other, *frames[i + 1 :]) for i in range(len(frames)) for other in others],
        len(frames),
    )


def _moved(frames: tuple[int, ...], reach: int, total: int) -> NDArray[np.int64]:
    """All choices in which each frame is at most ``reach`` frames earlier or later."""
    steps = np.arange(-reach, reach + 1)
    axes = np.meshgrid(*(steps + frame for frame in frames), indexing="ij")
    moved = np.stack([axis.ravel() for axis in axes], axis=1)
    apart = (np.diff(moved, axis=1) > 0).all(axis=1)
    return moved[apart & (moved[:, 0] >= 1) & (moved[:, -1] <= total - 2)]


def _sorted(choices: list[tuple[int, ...]], size: int) -> NDArray[np.int64]:
    """(S, n) choices, the frames of each rising."""
    return np.sort(np.array(choices, dtype=np.int64).reshape(-1, size), axis=1)
