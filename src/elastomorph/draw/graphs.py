"""Graphs of the errors of methods, curve by curve and over time (Fig. 8)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.figure import new_figure
from elastomorph.draw.method_style import LineStyle, styles_for
from elastomorph.errors import ParameterError
from elastomorph.evaluation import Evaluation, MethodResult

__all__ = ["ORDERS", "error_graphs", "time_graphs"]

ORDERS = ("index", "length", "error")
MANY_CURVES = 200
"""Beyond this many curves, their numbers mean nothing to a reader."""
Errors = Callable[[MethodResult], NDArray[np.float64]]


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

    Raises:
        ParameterError: No such method, order or suffix.
        MissingExtraError: matplotlib is not installed.
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
    with new_figure(path, 11.0, 9.0) as figure:
        panels = figure.subplot_mosaic([["a", "a"], ["b", "b"], ["c", "d"]])
        where = np.arange(1, len(sorting) + 1)
        for key, word, errors in (("a", "average", _average), ("b", "maximum", _maximum)):
            axes = panels[key]
            for result in results:
                heights = 100 * errors(result)[:, pick].max(axis=1)[sorting]
                _line(axes, where, heights, styles[result.label], result.label, slim)
            _percent(axes, f"({key}) {word} error of each curve, {moment}", axis_label)
            axes.set_xlim(0.5, len(sorting) + 0.5)
        _over_time(panels["c"], times, results, styles, _average, "(c) average error over time")
        _over_time(panels["d"], times, results, styles, _maximum, "(d) maximum error over time")
        _legend(figure, panels["a"])
        if title:
            figure.suptitle(title, fontweight="bold", fontsize=13)


def time_graphs(
    evaluation: Evaluation,
    path: str | Path,
    *,
    labels: Sequence[str] | None = None,
    title: str = "",
) -> None:
    """Errors over time at the times of the frames (a, b) and with free timing (c, d).

    What falls from the upper graphs to the lower was a matter of timing, not of the path. The times
    of (c, d) make the peak of each line as low as it can be, never higher than in (a, b).

    Args:
        evaluation: Methods compared with a recorded motion.
        path: Graph to write: .png, .svg or .pdf.
        labels: The methods to show; all by default.
        title: Above the graph.

    Raises:
        ParameterError: No such method or suffix.
        MissingExtraError: matplotlib is not installed.
    """
    results = _results(evaluation, labels)
    times = evaluation.truth.times
    styles = styles_for([result.label for result in results])
    with new_figure(path, 11.0, 7.2) as figure:
        panels = figure.subplots(2, 2, sharey="col")
        for axes, errors, words in (
            (panels[0, 0], _average, "(a) average error at the times of the frames"),
            (panels[0, 1], _maximum, "(b) maximum error at the times of the frames"),
            (panels[1, 0], _path_average, "(c) average error with free timing"),
            (panels[1, 1], _path_maximum, "(d) maximum error with free timing"),
        ):
            _over_time(axes, times, results, styles, errors, words)
        _legend(figure, panels[0, 0])
        if title:
            figure.suptitle(title, fontweight="bold", fontsize=13)


def _average(result: MethodResult) -> NDArray[np.float64]:
    return result.average


def _maximum(result: MethodResult) -> NDArray[np.float64]:
    return result.maximum


def _path_average(result: MethodResult) -> NDArray[np.float64]:
    return result.path_average


def _path_maximum(result: MethodResult) -> NDArray[np.float64]:
    return result.path_maximum


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
    styles: dict[str, LineStyle],
    errors: Errors,
    title: str,
) -> None:
    for result in results:
        worst = 100 * errors(result).max(axis=0)
        _line(axes, times, worst, styles[result.label], result.label)
    _percent(axes, title, "t", "% of D, worst curve")
    axes.set_xlim(0, 1)


def _line(
    axes: Any,
    across: NDArray[Any],
    up: NDArray[np.float64],
    style: LineStyle,
    label: str,
    slim: float = 1.0,
) -> None:
    (line,) = axes.plot(
        across,
        up,
        color=style.colour,
        linewidth=style.width * slim,
        zorder=style.layer,
        label=label,
        solid_joinstyle="round",
    )
    if style.dashes:
        line.set_dashes(style.dashes)


def _percent(axes: Any, title: str, across: str, up: str = "% of D") -> None:
    axes.set_title(title)
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_ylim(bottom=0)


def _legend(figure: Any, axes: Any) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", handlelength=3.4)
