"""The table of an evaluation as HTML, for notebooks and pages, light or dark."""

from __future__ import annotations

import html
from typing import TYPE_CHECKING

from elastomorph.evaluation.summary import conclusions, informed_methods, rankings, summaries
from elastomorph.evaluation.table import LEGEND, table_columns, table_title

if TYPE_CHECKING:
    from elastomorph.evaluation.results import Evaluation

__all__ = ["evaluation_html"]

# No colour of its own: text and lines are those of whatever it stands in, even where the page
# around it has no doctype, for which tables begin anew in black.
_TABLE = "border-collapse: collapse; color: inherit; font: inherit"
_LINE = "border-bottom: 1px solid currentColor"
_NUMBER = "text-align: right; font-variant-numeric: tabular-nums; padding-left: 1em"
_WORDS = "text-align: left; caption-side: bottom; padding-top: 0.5em; max-width: 50em"


def evaluation_html(evaluation: Evaluation) -> str:
    """The methods as a table, best of each column marked, and in words what it shows.

    With three methods or more their order follows, as timed and with free timing.
    """
    lines = summaries(evaluation)
    columns = table_columns(lines, shape=len(evaluation.truth.mesh.faces) > 0)
    heads = "".join(
        f'<th scope="col" style="{_NUMBER}; {_LINE}">{_text(column.header)}</th>'
        for column in columns
    )
    rows = []
    for number, line in enumerate(lines):
        cells = "".join(
            f'<td style="{_NUMBER}">{_cell(column.texts[number], column.best[number])}</td>'
            for column in columns
        )
        name = f'<th scope="row" style="text-align: left">{_text(line.label)}</th>'
        rows.append(f"<tr>{name}{cells}</tr>")
    words = conclusions(lines, informed_methods(evaluation))
    words += rankings(lines) if len(lines) > 2 else []
    caption = f"{_text(table_title(evaluation))}. {_text(LEGEND)}"
    return "\n".join(
        [
            f'<table style="{_TABLE}">',
            f'<caption style="{_WORDS}">{caption}</caption>',
            f'<thead><tr><th scope="col" style="text-align: left; {_LINE}">method</th>{heads}</tr>'
            "</thead>",
            f"<tbody>{''.join(rows)}</tbody>",
            "</table>",
            *(f"<p>{_text(sentence)}</p>" for sentence in words),
        ]
    )


def _cell(text: str, best: bool) -> str:
    # Bold and underlined: in small sizes and some fonts, bold digits alone are hardly seen.
    if not best:
        return _text(text)
    return f'<strong style="text-decoration: underline">{_text(text)}</strong>'


def _text(text: str) -> str:
    return html.escape(text).replace("\n", "<br>")
