"""Graphs of errors: of methods (Fig. 8), of the movements of a take, of in-betweens."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.figure import dress, legend, new_figure, styles_for
from elastomorph.errors import ParameterError
from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.evaluation.inbetweens import Suggestion
from elastomorph.evaluation.movements import JudgedMovement
from elastomorph.evaluation.words import NOTHING

ORDERS = ("index", "length", "error")
MANY_CURVES = 200
"""Beyond this many curves, their numbers mean nothing to a reader."""
_MANY_MOVEMENTS = 24
"""With more movements than this their frames could not be read below each other."""
_MANY_INBETWEENS = 10
"""With more in-betweens than this, nobody could tell the lines of a legend apart."""
_LINEAR = "#b0b0b0"
_FEWEST, _MOST = np.array([0.56, 0.80, 0.95]), np.array([0.00, 0.16, 0.36])


def error_graphs(
    evaluation: Evaluation,
    path: str | Path,
    *,
    labels: Sequence[str] | None = None,
    time: float | None = None,
    order: str | None = None,
    title: str = "",
) -> None:
    """Average (a) and maximum (b) error of each curve, and both over time (c, d), in % of D.

    Args:
        evaluation: Methods compared with a recorded motion.
        path: Graph to write: .png, .svg or .pdf.
        labels: The methods to show; all by default.
        time: (a) and (b) show the recorded frame nearest to this time; by default each curve's
            largest error over all frames.
        order: Of curves from left to right: ``index``; ``length``, the longest first; ``error``,
            the worst under the first method first. By default the index, or the error where
            there are more than 200 curves.
        title: Above the graph.
    """
    results = _results(evaluation, labels)
    times = evaluation.truth.times
    if time is None:
        pick, moment = slice(None), "largest over time"
    else:
        frame = int(np.abs(times - time).argmin())
        pick, moment = slice(frame, frame + 1), f"at t = {times[frame]:.2g}"
    kind = order or ("error" if len(evaluation.curves) > MANY_CURVES else "index")
    sorting, axis_label = _order(evaluation, results[0], kind, pick)
    styles = styles_for([result.label for result in results])
    slim = float(np.clip(60 / max(1, len(sorting)), 0.35, 1.0)) ** 0.5
    with new_figure(path, 11.0, 9.0, title) as figure:
        panels = figure.subplot_mosaic([["a", "a"], ["b", "b"], ["c", "d"]])
        where = np.arange(1, len(sorting) + 1)
        for axes, letter, kind in ((panels["a"], "a", "average"), (panels["b"], "b", "maximum")):
            for result in results:
                heights = 100 * getattr(result, kind)[:, pick].max(axis=1)[sorting]
                axes.plot(where, heights, **styles[result.label].of(result.label, slim))
            dress(axes, f"({letter}) {kind} error of each curve, {moment}", axis_label, "% of D")
            axes.set_xlim(0.5, len(sorting) + 0.5)
        _over_time(panels["c"], times, results, "average", "(c) average error over time")
        _over_time(panels["d"], times, results, "maximum", "(d) maximum error over time")
        legend(figure, panels["a"])


def time_graphs(
    evaluation: Evaluation,
    path: str | Path,
    *,
    labels: Sequence[str] | None = None,
    title: str = "",
) -> None:
    """Errors over time at the times of the frames (a, b) and with free timing (c, d).

    What falls from the upper graphs to the lower was a matter of timing, not of the path. The times
    of (c, d) make the peak of each line as low as it can be, never higher than in (a, b). Arguments
    as for `error_graphs`.
    """
    results = _results(evaluation, labels)
    with new_figure(path, 11.0, 7.2, title) as figure:
        panels = figure.subplots(2, 2, sharey="col")
        for axes, errors, words in (
            (panels[0, 0], "average", "(a) average error at the times of the frames"),
            (panels[0, 1], "maximum", "(b) maximum error at the times of the frames"),
            (panels[1, 0], "path_average", "(c) average error with free timing"),
            (panels[1, 1], "path_maximum", "(d) maximum error with free timing"),
        ):
            _over_time(axes, evaluation.truth.times, results, errors, words)
        legend(figure, panels[0, 0])


def _results(evaluation: Evaluation, labels: Sequence[str] | None) -> list[MethodResult]:
    chosen = evaluation.results if labels is None else [evaluation[label] for label in labels]
    if not chosen:
        raise ParameterError("there is no method to draw")
    return list(chosen)


def _order(
    evaluation: Evaluation, first: MethodResult, kind: str, pick: slice
) -> tuple[NDArray[np.intp], str]:
    """Order of the curves from left to right, and what to call the axis."""
    count = len(evaluation.curves)
    if kind == "index":
        return np.arange(count), "curve"
    if kind == "length":
        vertices = evaluation.truth.mesh.vertices
        lengths = [
            float(np.linalg.norm(np.diff(vertices[curve.edges], axis=1), axis=2).sum())
            for curve in evaluation.curves
        ]
        return np.argsort(lengths, kind="stable")[::-1], "curves, the longest first"
    if kind == "error":
        worst = first.maximum[:, pick].max(axis=1)
        words = f"{count:,} curves, the largest maximum error of '{first.label}' first"
        return np.argsort(-worst, kind="stable"), words
    raise ParameterError(f"order must be one of {', '.join(ORDERS)}, found {kind!r}")


def _over_time(
    axes: Any,
    times: NDArray[np.float64],
    results: Sequence[MethodResult],
    errors: str,
    title: str,
) -> None:
    styles = styles_for([result.label for result in results])
    for result in results:
        worst = 100 * getattr(result, errors).max(axis=0)
        axes.plot(times, worst, **styles[result.label].of(result.label))
    dress(axes, title, "t", "% of D, worst curve", whole_time=True)


def movement_graph(judged: Sequence[JudgedMovement], path: str | Path, *, title: str = "") -> None:
    """LME of each movement at the recorded times (a) and with free timing (b), in % of D."""
    if not judged:
        raise ParameterError("there is no movement to draw")
    styles = styles_for([result.label for result in judged[0].evaluation.results])
    where = np.arange(1, len(judged) + 1)
    with new_figure(path, 11.0, 7.0, title) as figure:
        panels = figure.subplots(2, 1, sharex=True, sharey=True)
        for axes, words, errors in (
            (panels[0], "(a) largest error at the recorded times", "lme"),
            (panels[1], "(b) largest error with free timing", "path_lme"),
        ):
            for label, style in styles.items():
                heights = [100 * getattr(one.evaluation[label], errors) for one in judged]
                axes.plot(where, heights, marker="o", markersize=4, **style.of(label))
            dress(axes, words, "movement" if errors == "path_lme" else "", "LME, % of D")
        if len(judged) <= _MANY_MOVEMENTS:
            names = [f"{n}\n{one.movement.kind}" for n, one in enumerate(judged, start=1)]
            panels[1].set_xticks(where, names)
        legend(figure, panels[0])


def inbetween_graph(
    suggestions: Sequence[Suggestion],
    times: NDArray[np.float64],
    path: str | Path,
    *,
    title: str = "",
) -> None:
    """LME and LAE by the number of in-betweens (a), and the largest error over time (b).

    Dots in (b) are where the in-betweens are. There is one suggestion for each number of them, see
    `suggest_inbetweens`, and (T,) times of the frames of the motion.
    """
    if not suggestions:
        raise ParameterError("there is no suggestion to draw")
    with new_figure(path, 11.0, 4.6, title) as figure:
        by_number, over_time = figure.subplots(1, 2, width_ratios=(1, 1.6))
        _errors_by_number(by_number, suggestions)
        _errors_over_time(over_time, suggestions, times)


def _errors_by_number(axes: Any, suggestions: Sequence[Suggestion]) -> None:
    numbers = [len(suggestion.frames) for suggestion in suggestions]
    largest = [100 * suggestion.lme for suggestion in suggestions]
    average = [100 * suggestion.lae for suggestion in suggestions]
    axes.plot(numbers, largest, "o-", color="#0060a8", label="LME", clip_on=False)
    axes.plot(numbers, average, "s--", color="#c44e00", label="LAE", clip_on=False)
    for number, error in zip(numbers[1:], largest[1:], strict=True):
        if error > 100 * NOTHING:
            axes.annotate(
                f"÷{largest[0] / error:.2g}",
                (number, error),
                xytext=(5, 6),
                textcoords="offset points",
                color="#0060a8",
            )
    dress(axes, "(a) error by number of in-betweens", "in-betweens", "% of D")
    axes.locator_params(axis="x", integer=True)
    axes.legend(loc="upper right")


def _errors_over_time(
    axes: Any, suggestions: Sequence[Suggestion], times: NDArray[np.float64]
) -> None:
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
    dress(axes, "(b) largest error over time", "t", "", whole_time=True)
    if len(suggestions) <= _MANY_INBETWEENS + 1:
        axes.legend(title="in-betweens", loc="upper left", bbox_to_anchor=(1.0, 1.0))
