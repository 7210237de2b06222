"""A graph of what in-betweens are worth: errors by their number, and over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.figure import new_figure
from elastomorph.errors import ParameterError
from elastomorph.evaluation.inbetweens import Suggestion

__all__ = ["inbetween_graph"]

_LINEAR = "#b0b0b0"
_FEWEST, _MOST = np.array([0.56, 0.80, 0.95]), np.array([0.00, 0.16, 0.36])
_NAMED = 10
"""With more in-betweens than this, nobody could tell the lines of a legend apart."""


def inbetween_graph(
    suggestions: Sequence[Suggestion],
    times: NDArray[np.float64],
    path: str | Path,
    *,
    title: str = "",
) -> None:
    """LME and LAE by the number of in-betweens (a), and the largest error over time (b).

    Dots in (b) are where the in-betweens are.

    Args:
        suggestions: One for each number of in-betweens, see `suggest_inbetweens`.
        times: (T,) times of the frames of the motion.
        path: Graph to write: .png, .svg or .pdf.
        title: Above the graph.

    Raises:
        ParameterError: There is no suggestion, or another suffix.
        FileError: The file cannot be written.
        MissingExtraError: matplotlib is not installed.
    """
    if not suggestions:
        raise ParameterError("there is no suggestion to draw")
    with new_figure(path, 11.0, 4.6) as figure:
        by_number, over_time = figure.subplots(1, 2, width_ratios=(1, 1.6))
        _by_number(by_number, suggestions)
        _over_time(over_time, suggestions, times)
        if title:
            figure.suptitle(title, fontweight="bold", fontsize=13)


def _by_number(axes: Any, suggestions: Sequence[Suggestion]) -> None:
    numbers = [len(suggestion.frames) for suggestion in suggestions]
    largest = [100 * suggestion.lme for suggestion in suggestions]
    average = [100 * suggestion.lae for suggestion in suggestions]
    axes.plot(numbers, largest, "o-", color="#0060a8", label="LME", clip_on=False)
    axes.plot(numbers, average, "s--", color="#c44e00", label="LAE", clip_on=False)
    for number, error in zip(numbers[1:], largest[1:], strict=True):
        if error > 0:
            axes.annotate(
                f"÷{largest[0] / error:.2g}",
                (number, error),
                xytext=(5, 6),
                textcoords="offset points",
                color="#0060a8",
            )
    axes.set_title("(a) error by number of in-betweens")
    axes.set_xlabel("in-betweens")
    axes.set_ylabel("% of D")
    axes.set_ylim(bottom=0)
    axes.locator_params(axis="x", integer=True)
    axes.legend(loc="upper right")


def _over_time(axes: Any, suggestions: Sequence[Suggestion], times: NDArray[np.float64]) -> None:
    shades = np.linspace(0.0, 1.0, max(2, len(suggestions) - 1))
    for i, suggestion in enumerate(suggestions):
        linear = not suggestion.frames
        colour = _LINEAR if linear else tuple((1 - shades[i - 1]) * _FEWEST + shades[i - 1] * _MOST)
        error = 100 * suggestion.maximum
        label = "linear" if linear else str(len(suggestion.frames))
        axes.plot(times, error, color=colour, linewidth=3.5 if linear else 1.6, label=label)
        if not linear:
            where = list(suggestion.frames)
            axes.plot(times[where], error[where], "o", color=colour, markersize=5, clip_on=False)
    axes.set_title("(b) largest error over time")
    axes.set_xlabel("t")
    axes.set_xlim(0, 1)
    axes.set_ylim(bottom=0)
    if len(suggestions) <= _NAMED + 1:
        axes.legend(title="in-betweens", loc="upper left", bbox_to_anchor=(1.0, 1.0))
