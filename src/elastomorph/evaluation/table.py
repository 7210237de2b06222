"""The table of an evaluation, for terminals and notebooks."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from elastomorph.evaluation.conclusions import conclusions, rankings
from elastomorph.evaluation.summary import MethodSummary, informed_methods, summaries

if TYPE_CHECKING:
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
LEGEND = (
    "Errors and seam in % of D. path: the frames pick, in order, the moments of the path at which "
    "the error is smallest; what vanishes there was timing. Bold: best of the column."
)


def evaluation_table(evaluation: Evaluation) -> Group:
    """The methods of one evaluation as a table, and in words what it shows."""
    lines = summaries(evaluation)
    words = [Text(sentence) for sentence in conclusions(lines, informed_methods(evaluation))]
    has_polygons = len(evaluation.truth.mesh.faces) > 0
    return Group(method_table(lines, _title(evaluation), shape=has_polygons), *words)


def method_table(lines: Sequence[MethodSummary], title: str, *, shape: bool = True) -> Table:
    """A row a method, the best of each column bold, unless all are alike; markers have no shape."""
    # Narrow enough for a terminal of 80 columns: cut numbers are no numbers.
    table = Table(
        title=title,
        caption=LEGEND,
        caption_justify="left",
        title_justify="left",
        box=SIMPLE_HEAD,
        padding=0,
        pad_edge=False,
    )
    table.add_column("method", no_wrap=True)
    cells = []
    for column in _columns(lines, shape=shape):
        table.add_column(column.header, justify="right", no_wrap=True)
        cells.append(
            [
                Text(text, style="bold" if best else "")
                for text, best in zip(column.texts, column.best, strict=True)
            ]
        )
    for line, row in zip(lines, zip(*cells, strict=True), strict=True):
        table.add_row(Text(line.label), *row)
    return table


def evaluation_html(evaluation: Evaluation) -> str:
    """The same for a notebook; with three methods or more their order follows."""
    from elastomorph.templates import rendered  # a terminal does without its import

    lines = summaries(evaluation)
    sentences = conclusions(lines, informed_methods(evaluation))
    return rendered(
        "elastomorph.evaluation",
        "table.html",
        title=_title(evaluation),
        legend=LEGEND,
        columns=_columns(lines, shape=len(evaluation.truth.mesh.faces) > 0),
        labels=[line.label for line in lines],
        sentences=sentences + (rankings(lines) if len(lines) > 2 else []),
    )


def number_text(line: MethodSummary, name: str) -> str:
    """A number of a method as tables show it: errors in %, counts, ratios."""
    value = float(getattr(line, name))
    if name == "flips":
        return f"{value:.0f}" if value.is_integer() else f"{value:.1f}"
    return f"{value:.3f}" if name == "stretch" else f"{100 * value:.3f}"


@dataclass(frozen=True)
class _Column:
    """A column of numbers as they are read; none is the best where all are alike."""

    header: str
    texts: tuple[str, ...]
    best: tuple[bool, ...]


def _columns(lines: Sequence[MethodSummary], *, shape: bool) -> list[_Column]:
    columns = []
    for header, name in (_COLUMNS | (SHAPE_COLUMNS if shape else {})).items():
        values = [float(getattr(line, name)) for line in lines]
        texts = tuple(number_text(line, name) for line in lines)
        # What reads the same is equally good: a digit nobody sees must not pick a winner.
        best = texts[values.index(min(values))]
        alike = len(set(texts)) == 1
        columns.append(_Column(header, texts, tuple(t == best and not alike for t in texts)))
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
