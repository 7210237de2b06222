"""The table of an evaluation, for the terminal."""

from __future__ import annotations

import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.console import Console, Group
from rich.table import Table
from rich.text import Text

from elastomorph.evaluation.summary import (
    MethodSummary,
    conclusions,
    informed_methods,
    summaries,
)

if TYPE_CHECKING:
    from elastomorph.evaluation.results import Evaluation

__all__ = [
    "LEGEND",
    "Column",
    "evaluation_table",
    "method_table",
    "plain_text",
    "table_columns",
    "table_title",
]


def _percent(value: float) -> str:
    return f"{100 * value:.3f}"


def _count(value: float) -> str:
    return f"{value:.0f}" if float(value).is_integer() else f"{value:.1f}"


def _ratio(value: float) -> str:
    return f"{value:.3f}"


_COLUMNS: tuple[tuple[str, str, Callable[[float], str]], ...] = (
    ("LME", "lme", _percent),
    ("LAE", "lae", _percent),
    ("mean\nLME", "mean_lme", _percent),
    ("mean\nLAE", "mean_lae", _percent),
    ("path\nLME", "path_lme", _percent),
    ("path\nLAE", "path_lae", _percent),
)
_SHAPE_COLUMNS: tuple[tuple[str, str, Callable[[float], str]], ...] = (
    ("seam", "seam", _percent),
    ("flips", "flips", _count),
    ("stretch", "stretch", _ratio),
)
LEGEND = (
    "Errors and seam in % of D. path: the frames pick, in order, the moments of the path at which "
    "the error is smallest; what vanishes there was timing. Bold: best of the column."
)


def evaluation_table(evaluation: Evaluation) -> Group:
    """The methods of one evaluation as a table, and in words what it shows."""
    lines = summaries(evaluation)
    words = [Text(sentence) for sentence in conclusions(lines, informed_methods(evaluation))]
    has_polygons = len(evaluation.truth.mesh.faces) > 0
    return Group(method_table(lines, table_title(evaluation), shape=has_polygons), *words)


def method_table(lines: Sequence[MethodSummary], title: str, *, shape: bool = True) -> Table:
    """A table with one row a method; the best of each column is bold, unless all are alike.

    Args:
        lines: The methods.
        title: What was measured.
        shape: Whether there are columns for seam, flips and stretch, which markers do not have.
    """
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
    for column in table_columns(lines, shape=shape):
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


@dataclass(frozen=True)
class Column:
    """A column of numbers as they are read.

    Attributes:
        header: Its title, in at most two lines.
        texts: One a method.
        best: Whether each of them is the best of the column; none is where all are alike.
    """

    header: str
    texts: tuple[str, ...]
    best: tuple[bool, ...]


def table_columns(lines: Sequence[MethodSummary], *, shape: bool = True) -> list[Column]:
    """The columns of a table of methods; arguments as for `method_table`."""
    columns = []
    for header, name, written in (*_COLUMNS, *(_SHAPE_COLUMNS if shape else ())):
        values = [getattr(line, name) for line in lines]
        texts = tuple(written(value) for value in values)
        # What reads the same is equally good: a digit nobody sees must not pick a winner.
        best = texts[values.index(min(values))]
        alike = len(set(texts)) == 1
        columns.append(Column(header, texts, tuple(t == best and not alike for t in texts)))
    return columns


def table_title(evaluation: Evaluation) -> str:
    """What was measured."""
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
