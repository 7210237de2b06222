"""Table 1 as HTML: the best of each column is marked by more than a colour."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

from elastomorph.evaluation.summary import MethodSummary, places, same
from elastomorph.report.about import SPACE
from elastomorph.report.markup import Markup, element

__all__ = ["error_table", "ranking_lists", "scrolling"]


@dataclass(frozen=True)
class _Column:
    """One number of each method."""

    title: str
    name: str
    written: Callable[[float], str]


def _percent(value: float) -> str:
    return f"{100 * value:.3f}"


def _count(value: float) -> str:
    return f"{value:.0f}" if float(value).is_integer() else f"{value:.1f}"


def _ratio(value: float) -> str:
    return f"{value:.3f}"


def _errors(prefix: str) -> tuple[_Column, ...]:
    return tuple(
        _Column(title, prefix + name, _percent)
        for title, name in (
            ("LME", "lme"),
            ("LAE", "lae"),
            ("mean LME", "mean_lme"),
            ("mean LAE", "mean_lae"),
        )
    )


_TIMED, _FREE = _errors(""), _errors("path_")
_SHAPE = (
    _Column("seam", "seam", _percent),
    _Column("flips", "flips", _count),
    _Column("stretch", "stretch", _ratio),
)


def error_table(
    lines: Sequence[MethodSummary],
    caption: str,
    *,
    informed: Collection[str] = (),
    shape: bool = True,
    timing_known: bool = True,
) -> Markup:
    """One row a method, in three groups of columns: at the times, with free timing, shape.

    Args:
        lines: The methods.
        caption: What was measured.
        informed: Methods that were given frames of the recording; none of them is called the best.
        shape: Whether there are seams, flips and stretch, which markers do not have.
        timing_known: Whether errors at given times mean anything; if not, none of them is called
            the best.
    """
    groups = [
        ("At the recorded times" if timing_known else "At constant speed, assumed", _TIMED),
        ("With free timing", _FREE),
    ]
    if shape:
        groups.append(("Shape", _SHAPE))
    first = element("th", "Method", scope="col", rowspan=2, class_="name")
    over = [
        element("th", title, scope="colgroup", colspan=len(columns)) for title, columns in groups
    ]
    columns = [column for _, group in groups for column in group]
    under = [element("th", column.title, scope="col") for column in columns]
    cells = [
        _column(column, lines, informed if timing_known or column not in _TIMED else None)
        for column in columns
    ]
    rows = [
        element("tr", _name(line.label, informed), *row)
        for line, row in zip(lines, zip(*cells, strict=True), strict=True)
    ]
    table = element(
        "table",
        element("caption", caption),
        element("colgroup", element("col")),
        *(
            element("colgroup", *(element("col") for _ in group), class_="apart")
            for _, group in groups
        ),
        element("thead", element("tr", first, *over), element("tr", *under)),
        element("tbody", *rows),
        class_="errors",
    )
    return scrolling(table, caption)


_STAR = element("span", "★", class_="star", aria_hidden="true")
_BEST = element("span", " best", class_="unseen")
_TOLD = element("span", "†", aria_hidden="true")
_TOLD_WORDS = element("span", "(knows frames of the recording)", class_="unseen")


def _name(label: str, informed: Collection[str]) -> Markup:
    mark = (" ", _TOLD, _TOLD_WORDS) if label in informed else ()
    return element("th", label, *mark, scope="row", class_="name")


def _column(
    column: _Column, lines: Sequence[MethodSummary], informed: Collection[str] | None
) -> list[Markup]:
    """The cells of a column; without anyone informed or not, none of them is marked."""
    texts = [column.written(float(getattr(line, column.name))) for line in lines]
    judged = {
        line.label: float(getattr(line, column.name))
        for line in lines
        if informed is not None and line.label not in informed
    }
    least = min(judged.values(), default=0.0)
    # A difference that nobody can see must not pick a winner.
    good = {
        label
        for label, value in judged.items()
        if value == least or (math.isfinite(value) and same(value, least))
    }
    if len(good) == len(judged):
        return [element("td", text) for text in texts]
    return [
        element("td", _STAR, element("b", text), _BEST, class_="best")
        if line.label in good
        else element("td", text)
        for text, line in zip(texts, lines, strict=True)
    ]


def ranking_lists(
    lines: Sequence[MethodSummary], *, timing_known: bool = True, heading: str = "h3"
) -> Markup:
    """The methods in order of LME, at the recorded times and with free timing; ties share a place.

    Args:
        lines: The methods.
        timing_known: Whether errors at given times mean anything.
        heading: Level of the headings.
    """
    kinds = [("Ranking with free timing", "path_lme")]
    if timing_known:
        kinds.insert(0, ("Ranking at the recorded times", "lme"))
    found = []
    for title, name in kinds:
        items = []
        for place in places(lines, name):
            errors = [_percent(getattr(line, name)) for line in place]
            span = errors[0] if len(set(errors)) == 1 else f"{errors[0]} to {errors[-1]}"
            names = ", ".join(line.label for line in place)
            items.append(
                element("li", names, " ", element("span", f"{span}{SPACE}%", class_="number"))
            )
        found.append(element("div", element(heading, title), element("ol", *items)))
    return element("div", *found, class_="rankings")


def scrolling(content: Markup, label: str) -> Markup:
    """What may be wider than a phone, in a frame that scrolls sideways, by keyboard too."""
    return element(
        "div", content, class_="scroll", tabindex=0, role="region", aria_label=f"{label} (scrolls)"
    )
