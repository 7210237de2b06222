"""The numbers of an evaluation: tables for terminals and notebooks, CSV, JSON and pandas."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from elastomorph.errors import MissingExtraError
from elastomorph.evaluation.conclusions import conclusions, rankings
from elastomorph.evaluation.confidence import coverage_facts
from elastomorph.evaluation.curve_errors import CurveVertices
from elastomorph.evaluation.summary import MethodSummary, informed_methods, summaries

if TYPE_CHECKING:
    from pandas import DataFrame

    from elastomorph.evaluation.results import Evaluation

_COLUMNS = {
    "LME": "lme",
    "LAE": "lae",
    "mean\nLME": "mean_lme",
    "mean\nLAE": "mean_lae",
    "path\nLME": "path_lme",
    "path\nLAE": "path_lae",
}
SHAPE_COLUMNS = {"seam": "seam", "flips": "flips", "stretch": "stretch"}
"""Headers and numbers that tell of a surface, which markers do not have."""
UNMASKED_COLUMNS = {"all\nLME": "unmasked_lme"}
"""Where vertices of low confidence do not count: the same with them."""
_UNMASKED_WORDS = " all: vertices of low confidence too, which do not count in the others."
LEGEND = (
    "Errors and seam in % of D. path: the frames pick, in order, the moments of the path at which "
    "the error is smallest; what vanishes there was timing. Bold: best of the column."
)


def evaluation_table(evaluation: Evaluation) -> Group:
    """The methods of one evaluation as a table, and in words what it shows."""
    lines = summaries(evaluation)
    sentences = conclusions(lines, informed_methods(evaluation))
    words = [Text(sentence) for sentence in [*sentences, *_coverage(evaluation)]]
    has_polygons = len(evaluation.truth.mesh.faces) > 0
    return Group(method_table(lines, _title(evaluation), shape=has_polygons), *words)


def method_table(lines: Sequence[MethodSummary], title: str, *, shape: bool = True) -> Table:
    """A row a method, the best of each column bold, unless all are alike; markers have no shape."""
    # Narrow enough for a terminal of 80 columns: cut numbers are no numbers.
    masked = any(line.unmasked_lme is not None for line in lines)
    table = Table(
        title=title,
        caption=LEGEND + _UNMASKED_WORDS * masked,
        caption_justify="left",
        title_justify="left",
        box=SIMPLE_HEAD,
        padding=0,
        pad_edge=False,
    )
    table.add_column("method", no_wrap=True)
    columns = _columns(lines, shape=shape)
    for header in columns:
        table.add_column(header, justify="right", no_wrap=True)
    for line, *row in zip(lines, *columns.values(), strict=True):
        cells = [Text(text, style="bold" if best else "") for text, best in row]
        table.add_row(Text(line.label), *cells)
    return table


PAPER_TABLE_1 = {
    "beam R=1": ("Linear PDE", 0.021548, 0.009358),
    "beam R=2": ("Quadratic PDE", 0.010629, 0.006903),
    "beam R=3": ("Cubic PDE", 0.010826, 0.007916),
    "linear": ("Geometric linear", 0.024761, 0.011378),
}
"""The paper's Table 1: its name of each method, its LME and its LAE, as fractions of D."""


def table_1(evaluation: Evaluation) -> list[tuple[str, list[str]]]:
    """The rows of the paper's Table 1, its own and those found here, as fractions of D.

    Columns are those of `PAPER_TABLE_1`. No rows where one of its methods was not compared.
    """
    found = {line.label: line for line in summaries(evaluation)}
    if not found.keys() >= PAPER_TABLE_1.keys():
        return []
    _, *paper = zip(*PAPER_TABLE_1.values(), strict=True)
    here = ([getattr(found[label], name) for label in PAPER_TABLE_1] for name in ("lme", "lae"))
    return [
        (f"{name}, {whose}", [f"{value:.6f}" for value in values])
        for whose, pair in (("the paper", paper), ("here", here))
        for name, values in zip(("LME", "LAE"), pair, strict=True)
    ]


def evaluation_html(evaluation: Evaluation) -> str:
    """The same for a notebook; with three methods or more their order follows."""
    from elastomorph.templates import rendered  # a terminal does without its import

    lines = summaries(evaluation)
    sentences = conclusions(lines, informed_methods(evaluation))
    return rendered(
        "elastomorph.evaluation",
        "table.html",
        title=_title(evaluation),
        legend=LEGEND + _UNMASKED_WORDS * (evaluation.confidence is not None),
        columns=_columns(lines, shape=len(evaluation.truth.mesh.faces) > 0),
        labels=[line.label for line in lines],
        sentences=[
            *sentences,
            *_coverage(evaluation),
            *(rankings(lines) if len(lines) > 2 else []),
        ],
    )


def number_text(line: MethodSummary, name: str) -> str:
    """A number of a method as tables show it: errors in %, counts, ratios."""
    value = float(getattr(line, name))
    if name == "flips":
        return f"{value:.0f}" if value.is_integer() else f"{value:.1f}"
    return f"{value:.3f}" if name == "stretch" else f"{100 * value:.3f}"


def _columns(lines: Sequence[MethodSummary], *, shape: bool) -> dict[str, list[tuple[str, bool]]]:
    """By header the numbers as they are read, and which are best; none where all are alike."""
    columns = {}
    names = _COLUMNS | (SHAPE_COLUMNS if shape else {})
    if all(line.unmasked_lme is not None for line in lines):
        names |= UNMASKED_COLUMNS
    for header, name in names.items():
        values = [float(getattr(line, name)) for line in lines]
        texts = [number_text(line, name) for line in lines]
        # What reads the same is equally good: a digit nobody sees must not pick a winner.
        best = texts[values.index(min(values))]
        alike = len(set(texts)) == 1
        columns[header] = [(text, text == best and not alike) for text in texts]
    return columns


def _title(evaluation: Evaluation) -> str:
    return (
        f"{len(evaluation.truth)} frames, {len(evaluation.curves)} curves, "
        f"D = {evaluation.diameter:.4g}"
    )


def plain_text(renderable: Table | Group, width: int = 120) -> str:
    """What a terminal of this width would show, without colours or styles."""
    page = io.StringIO()
    console = Console(file=page, width=width, color_system=None, force_terminal=False)
    console.print(renderable)
    return "\n".join(line.rstrip() for line in page.getvalue().splitlines())


_MEASURED = (
    "average",
    "maximum",
    "path_times",
    "path_average_times",
    "path_average",
    "path_maximum",
)
"""Of a method in each frame, and but for times on each curve."""


def csv_text(evaluation: Evaluation, long: bool) -> str:
    """The rows in full precision; errors and seam are fractions of D."""
    page = io.StringIO()
    csv.writer(page, lineterminator="\n").writerows(_rows(evaluation, long))
    return page.getvalue()


def data_frame(evaluation: Evaluation, long: bool) -> DataFrame:
    """The rows as a table of pandas."""
    try:
        from pandas import DataFrame
    except ImportError:
        raise MissingExtraError("pandas") from None
    header, *rows = _rows(evaluation, long)
    return DataFrame(rows, columns=header)


def _rows(evaluation: Evaluation, long: bool) -> list[list[Any]]:
    """A header and one row a method, or for each method, curve and frame.

    ``path_maximum`` is taken at ``path_time``, ``path_average`` at ``path_average_time``.
    """
    if not long:
        lines = [line.facts() for line in summaries(evaluation)]
        return [list(lines[0]), *(list(line.values()) for line in lines)]
    header = [name.replace("times", "time") for name in _MEASURED]
    rows: list[list[Any]] = [["method", "curve", "frame", "time", *header]]
    truth = evaluation.truth
    for result in evaluation.results:
        measured = [getattr(result, name) for name in _MEASURED]
        for number, curve in enumerate(_curve_names(evaluation)):
            own = [each if each.ndim == 1 else each[number] for each in measured]
            columns = (each.tolist() for each in (truth.times, *own))
            rows += [
                [result.label, curve, *values] for values in zip(truth.names, *columns, strict=True)
            ]
    return rows


def evaluation_json(evaluation: Evaluation) -> str:
    """Everything measured, as strict JSON (an infinite stretch becomes null).

    Errors and seam are fractions of ``diameter``. ``average``, ``maximum``, ``path_average`` and
    ``path_maximum`` hold one row a curve and one column a frame; ``path_maximum`` is taken at
    ``path_times``, ``path_average`` at ``path_average_times``.
    """
    lines = summaries(evaluation)
    methods = []
    for line, result in zip(lines, evaluation.results, strict=True):
        entry = {
            name: value if isinstance(value, str) or math.isfinite(value) else None
            for name, value in line.facts().items()
        }
        for name in sorted(_MEASURED, key=lambda name: "times" not in name):
            entry[name] = getattr(result, name).tolist()
        methods.append(entry)
    page = {
        "unit": "fraction of diameter",
        "diameter": evaluation.diameter,
        "frames": list(evaluation.truth.names),
        "times": evaluation.truth.times.tolist(),
        "curves": [
            {"name": name, "vertices": len(curve.vertices), "closed": bool(curve.closed)}
            for name, curve in zip(_curve_names(evaluation), evaluation.curves, strict=True)
        ],
        "methods": methods,
        "conclusions": conclusions(lines),
    }
    if evaluation.confidence is not None:
        along = CurveVertices.of(evaluation.curves, len(evaluation.truth.mesh.vertices))
        page["confidence"] = coverage_facts(evaluation.confidence, along, evaluation.truth)
    if evaluation.settings is not None:
        page["settings"] = dict(evaluation.settings)
    return json.dumps(page, allow_nan=False, ensure_ascii=False) + "\n"


def _coverage(evaluation: Evaluation) -> list[str]:
    """How much of the vertices count, where not all do."""
    return [f"Confidence: {evaluation.coverage}."] if evaluation.confidence is not None else []


def _curve_names(evaluation: Evaluation) -> list[str]:
    """The name of each curve, or its number where it has none."""
    return [curve.name or str(number) for number, curve in enumerate(evaluation.curves)]
