"""Pieces that reports share: the outcome, what columns mean, graphs and pictures with words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from elastomorph.report.about import Lengths
from elastomorph.report.graph import inline_graph
from elastomorph.report.markup import Markup, element, joined
from elastomorph.report.picture import Picture, picture_figure
from elastomorph.report.verdict import Verdict

__all__ = [
    "column_words",
    "graph_figure",
    "picture_content",
    "verdict_content",
]


def verdict_content(
    verdict: Verdict, remarks: Sequence[str], scope: str, rankings: Markup
) -> Markup:
    """The outcome in words and how far it reaches, the rankings beside it."""
    findings = [*verdict.findings, *remarks, scope]
    return joined(
        [
            element("p", verdict.headline, class_="headline"),
            element(
                "div",
                element("ul", *(element("li", text) for text in findings), class_="findings"),
                rankings,
                class_="outcome",
            ),
        ]
    )


def column_words(
    diameter: float | None, unit: str, *, shape: bool, informed: Sequence[str] = ()
) -> Markup:
    """What the columns of the table mean."""
    size = ""
    if diameter is not None:
        size = f" 1 % is {Lengths(diameter, unit).plain(0.01)}."
    words: list[object] = [
        f"All errors and the seam are in per cent of D, the size of the face.{size} ",
        element("b", "LME"),
        " is the largest distance of any vertex on any curve at any time, ",
        element("b", "LAE"),
        " the largest mean distance along one curve (the paper's Table 1); their ",
        element("b", "means"),
        " are over the inner frames. With ",
        element("b", "free timing"),
        " each frame is compared with a moment of the path of its own, in order: those "
        "at which the largest error is smallest. What falls there was timing.",
    ]
    if shape:
        words += [
            " ",
            element("b", "Seam"),
            " is the largest jump between neighbouring curves, ",
            element("b", "flips"),
            " are polygons turned over in the worst frame, ",
            element("b", "stretch"),
            " is the largest ratio of an edge's length to those at both ends.",
        ]
    words.append(" ★ marks the best of a column, and what is within 1 % of it.")
    if informed:
        words.append(" † was given frames of the recording, so it is not counted among the best.")
    return element("p", *words)


def graph_figure(
    draw: Callable[[Path], None], name: str, title: str, alt: str, text: str
) -> Markup:
    """A graph with its heading and caption."""
    graph = inline_graph(draw, name, alt)
    card = element(
        "div",
        graph,
        class_="card scroll",
        tabindex=0,
        role="region",
        aria_label=f"{title} (graph, scrolls)",
    )
    return element("figure", element("h3", title), card, element("figcaption", text))


def picture_content(pictures: Sequence[Picture]) -> Markup:
    """Pictures of faces under their headings."""
    return joined(
        element("div", element("h3", picture.title), picture_figure(picture))
        for picture in pictures
    )
