"""Graphs of errors: of methods (Fig. 8), of the movements of a take, of in-betweens."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.draw.pictures import imported
from elastomorph.errors import ParameterError
from elastomorph.evaluation import Evaluation, MethodResult
from elastomorph.evaluation.inbetweens import Suggestion
from elastomorph.evaluation.movements import JudgedMovement
from elastomorph.evaluation.words import NOTHING
from elastomorph.io.atomic import replacing
from elastomorph.physics import CLOSURES, Load, Material, mean_response, modal_response

# One way of making graphs: legible letters, a style for each method, files whole or not at all.

GRAPH_SUFFIXES = (".png", ".svg", ".pdf")
_SETTINGS: dict[str, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.5,
    "axes.titlesize": 11,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e8",
    "grid.linewidth": 0.8,
    "axes.axisbelow": True,
    "lines.dash_capstyle": "butt",
    "legend.frameon": False,
    "figure.constrained_layout.w_pad": 0.1,
    "figure.constrained_layout.h_pad": 0.1,
    "svg.fonttype": "none",  # words stay words: searched, copied, restyled
    "svg.hashsalt": "elastomorph",
}


@contextmanager
def new_figure(path: str | Path, width: float, height: float, title: str = "") -> Iterator[Any]:
    """A figure to draw in, of this size in inches, written when the block ends without an error.

    No window, no state shared with other figures.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in GRAPH_SUFFIXES:
        raise ParameterError(
            f"{path}: a graph is written as {', '.join(GRAPH_SUFFIXES)}, "
            f"found {suffix or 'no suffix'}"
        )
    with imported("matplotlib").rc_context(_SETTINGS):
        figure = imported("matplotlib.figure").Figure(figsize=(width, height), layout="constrained")
        yield figure
        if title:
            figure.suptitle(title, fontweight="bold", fontsize=13)
        # The date would make two runs differ that drew the same.
        dated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(suffix, {})
        with replacing(path) as file:
            figure.savefig(file, format=suffix[1:], dpi=150, metadata=dated)


def dress(axes: Any, title: str, across: str, up: str, *, whole_time: bool = False) -> None:
    """Give axes a title and their names; from 0 upwards, and from t = 0 to 1 where that is all."""
    axes.set_title(title)
    axes.set_xlabel(across)
    axes.set_ylabel(up)
    axes.set_ylim(bottom=0)
    if whole_time:
        axes.set_xlim(0, 1)


def legend(figure: Any, axes: Any) -> None:
    """Name the lines of these axes beside the graph, long enough to tell dashes apart."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", handlelength=3.4)


@dataclass(frozen=True)
class LineStyle:
    """How the line of a method is drawn; colours are told apart by the colour-blind.

    Dashes are lengths of dashes and gaps in line widths, none for a solid line; the width is in
    points; lines of a higher layer cover those of a lower.
    """

    colour: str
    dashes: tuple[float, ...] = ()
    width: float = 1.6
    layer: int = 3

    def of(self, label: str, slim: float = 1.0) -> dict[str, Any]:
        """Options of ``Axes.plot`` for a line with this label, slimmer by a factor."""
        return {
            "label": label,
            "color": self.colour,
            "dashes": self.dashes,
            "linewidth": self.width * slim,
            "zorder": self.layer,
        }


# Straight paths are broad and pale, beams narrow and dashed on top: where the two coincide, as
# linear and R = 1 do and ease and beam of one order nearly do, both are seen. So are rotation and
# auto, which takes it where it turns.
_KNOWN = {
    "linear": LineStyle("#b0b0b0", (), 4.5, 2),
    "beam R=1": LineStyle("#000000", (3.0, 2.5), 1.5, 4),
    "ease R=2": LineStyle("#8fcdf2", (), 4.5, 2),
    "beam R=2": LineStyle("#0060a8", (3.0, 2.5), 1.5, 4),
    "ease R=3": LineStyle("#f6c567", (), 4.5, 2),
    "beam R=3": LineStyle("#c44e00", (3.0, 2.5), 1.5, 4),
    "cosine": LineStyle("#009e73", (), 1.6, 3),
    "plate R=2": LineStyle("#6a3d9a", (1.2, 1.4), 1.8, 5),
    "arc": LineStyle("#b8860b", (), 1.6, 4),
    "rotation": LineStyle("#e6a3c8", (), 4.5, 3),
    "auto": LineStyle("#8c1d5b", (3.0, 2.5), 1.5, 5),
    "through 1": LineStyle("#66b266", (), 1.8, 5),
    "through 2": LineStyle("#116622", (), 1.8, 5),
}
_OTHERS = (
    LineStyle("#cc5f9a", (6.0, 2.0, 1.2, 2.0), 1.6, 5),
    LineStyle("#3b528b", (1.2, 1.4), 1.8, 5),
    LineStyle("#7a1f2b", (8.0, 2.0), 1.5, 5),
    LineStyle("#4d4d4d", (6.0, 1.5, 1.2, 1.5, 1.2, 1.5), 1.5, 5),
    LineStyle("#8a6d00", (2.0, 1.0), 1.5, 5),
)


def styles_for(labels: Sequence[str]) -> dict[str, LineStyle]:
    """The style of each method; those not well known take further ones in their order."""
    others = [label for label in labels if label not in _KNOWN]
    return {
        label: _KNOWN[label] if label in _KNOWN else _OTHERS[others.index(label) % len(_OTHERS)]
        for label in labels
    }


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


# Graphs of the time laws φ_n(t) that a material and a load give the modes of a curve.

MODES = (1, 2, 3, 4, 6, 8)
_CLOSURE_STYLES = {
    "unforced": LineStyle("#c44e00", (6.0, 2.0, 1.2, 2.0), 1.8, 2),
    "rest": LineStyle("#6a3d9a", (1.2, 1.4), 1.8, 2),
    "linear": LineStyle("#555555", (8.0, 2.0), 1.8, 2),
    "compatible": LineStyle("#009e73", (), 1.8, 2),
    "limit": LineStyle("#0060a8", (3.0, 2.5), 1.8, 2),
}
_VISIBLE = 1e-14
"""Differences below this are the rounding of the computation."""


def time_law_graph(
    path: str | Path,
    material: Material | None = None,
    *,
    load: Load | int = 2,
    modes: tuple[int, ...] = MODES,
    title: str = "",
) -> None:
    """The law of the mean under each closure (a), and how far each mode is from the limit law (b).

    The modes n of (b) are those of a closed curve with uniform parameter, B_n = 16π⁴kn⁴ (Eq. 19).
    The load is p(t), or R of t^R; the title names it and the material by default.
    """
    material = material or Material()
    load = Load.power(load) if isinstance(load, int) else load
    t = np.linspace(0.0, 1.0, 401)
    limit = _values(load.limit_law, t)
    m = material
    words = f"p(t) = {_polynomial(load)}, m = {m.mass:g}, c = {m.damping:g}, k = {m.rigidity:g}"
    with new_figure(path, 11.0, 4.8, title or words) as figure:
        means, gaps = figure.subplots(1, 2)
        means.plot(t, limit, color="#b9dcf3", linewidth=6, label="limit law p(t)/p(1)")
        for closure in CLOSURES:
            style = _CLOSURE_STYLES[closure]
            law = mean_response(closure, load, material)
            if np.isfinite(law).all():
                means.plot(t, _values(law, t), **style.of(f"φ₀ {closure}"))
            else:
                means.plot([], [], color=style.colour, label=f"φ₀ {closure} (singular)")
        means.set_title("(a) the mean of a curve, by closure")
        means.set_xlabel("t")
        means.set_ylabel("φ₀(t)")
        means.set_xlim(0, 1)
        means.legend(loc="best")
        _draw_gaps(gaps, t, load, material, modes)


def mode_law_graph(
    path: str | Path,
    materials: Sequence[Material],
    *,
    loads: Sequence[Load | int] = (1, 2, 3),
    modes: Sequence[int] = (1, 2, 3),
) -> None:
    """The laws φ_n themselves: a row for each load, a column for each material.

    Args:
        path: The picture (.png, .svg, .pdf).
        materials: m, c and k of each column.
        loads: p(t) of each row, or R of t^R.
        modes: n of a closed curve with uniform parameter, B_n = 16π⁴kn⁴ (Eq. 19).

    Raises:
        ParameterError: Another suffix.
    """
    t = np.linspace(0.0, 1.0, 201)
    rows = [Load.power(load) if isinstance(load, int) else load for load in loads]
    with new_figure(path, 2.3 * len(materials) + 0.4, 1.9 * len(rows) + 0.7) as figure:
        grid = figure.subplots(len(rows), len(materials), sharex=True, sharey="row", squeeze=False)
        for axes_of_row, load in zip(grid, rows, strict=True):
            for axes, material in zip(axes_of_row, materials, strict=True):
                _draw_laws(axes, t, load, material, modes)
            axes_of_row[0].set_ylabel(f"φₙ(t), p(t) = {_polynomial(load)}")
        for axes, m in zip(grid[0], materials, strict=True):
            axes.set_title(f"m = {m.mass:g}, c = {m.damping:g}, k = {m.rigidity:g}")
        for axes in grid[-1]:
            axes.set_xlabel("t")
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(handles))


def _draw_laws(
    axes: Any, t: NDArray[np.float64], load: Load, material: Material, modes: Sequence[int]
) -> None:
    limit = _values(load.limit_law, t)
    axes.plot(t, limit, color="#b9dcf3", linewidth=6, label="n → ∞: p(t)/p(1)")
    laws = modal_response(_stiffness(modes, material), load, material)
    for mode, law, shade in zip(modes, laws, np.linspace(0.0, 0.7, len(modes)), strict=True):
        if np.isfinite(law).all():
            axes.plot(t, _values(law, t), color=_blue(shade), label=f"n = {mode}")
        else:
            axes.plot([], [], color="#888888", label=f"n = {mode} (singular)")
    axes.set_xlim(0, 1)


def _stiffness(modes: Sequence[int], material: Material) -> NDArray[np.float64]:
    """B_n of a closed curve (Eq. 19)."""
    return 16 * np.pi**4 * material.rigidity * np.array(modes, dtype=np.float64) ** 4


def _blue(shade: float) -> tuple[float, float, float]:
    return (shade, 0.2 + 0.7 * shade, 0.45 + 0.5 * shade)


def _draw_gaps(
    axes: Any, t: NDArray[np.float64], load: Load, material: Material, modes: tuple[int, ...]
) -> None:
    laws = modal_response(_stiffness(modes, material), load, material) - load.limit_law
    shades = np.linspace(0.0, 0.75, len(modes))
    drawn = False
    for mode, law, shade in zip(modes, laws, shades, strict=True):
        gap = np.abs(_values(law, t))
        if not np.isfinite(gap).all():
            axes.plot([], [], color="#888888", label=f"n = {mode} (singular)")
        elif gap.max() > _VISIBLE:
            drawn = True
            gap[gap <= _VISIBLE] = np.nan
            axes.plot(t, gap, color=_blue(shade), linewidth=1.8, label=f"n = {mode}")
    axes.set_title("(b) closed curve: modes n off the limit law")
    axes.set_xlabel("t")
    axes.set_xlim(0, 1)
    axes.set_ylabel("|φₙ(t) - p(t)/p(1)|")
    if drawn:
        axes.set_yscale("log")
        axes.legend(loc="best", ncols=2)
    else:
        axes.set_yticks([])
        words = "every mode follows\nthe limit law exactly"
        axes.text(0.5, 0.5, words, transform=axes.transAxes, ha="center", va="center")


def _values(law: NDArray[np.float64], t: NDArray[np.float64]) -> NDArray[np.float64]:
    """The polynomial with these coefficients of t, t², and so on."""
    return np.asarray(np.polynomial.polynomial.polyval(t, np.concatenate([[0.0], law])))


def _polynomial(load: Load) -> str:
    powers = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
    terms = []
    for exponent, p in enumerate(load.coefficients, start=1):
        if p:
            factor = "" if p == 1 else f"{p:g}"
            terms.append(factor + "t" + ("" if exponent == 1 else str(exponent).translate(powers)))
    return " + ".join(terms)
