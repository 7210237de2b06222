"""The report of a long take: every movement in it judged, and their means."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from elastomorph.draw.graphs import movement_graph
from elastomorph.evaluation.movements import JudgedMovement, mean_lines
from elastomorph.evaluation.summary import (
    MethodSummary,
    informed_methods,
    places,
    summaries,
)
from elastomorph.model.sequence import MeshSequence
from elastomorph.report.about import About, Lengths, percent
from elastomorph.report.compared import counted, curve_words, diameter_words, face_words
from elastomorph.report.content import (
    column_words,
    graph_figure,
    verdict_content,
)
from elastomorph.report.document import Section, document
from elastomorph.report.error_table import error_table, ranking_lists, scrolling
from elastomorph.report.markup import Markup, element, joined
from elastomorph.report.recipe import fact_list, methods_table, recipe
from elastomorph.report.report import require_page_path, write_page
from elastomorph.report.verdict import reach_verdict

__all__ = ["movements_page", "write_movements_report"]

_SCOPE = (
    "All of this was measured on the movements of one take. On other faces and takes other methods "
    "have come closest."
)


def write_movements_report(
    judged: Sequence[JudgedMovement],
    take: MeshSequence,
    path: str | Path,
    about: About | None = None,
    *,
    draw: bool = True,
) -> None:
    """Write one self-contained HTML page about the movements of a take, the whole or nothing.

    Args:
        judged: Every movement with its evaluation, at least one.
        take: The whole take.
        path: The page, ``.html``; its folder must exist.
        about: Where the take came from, and the settings.
        draw: Draw a graph; without it the page needs no extra.

    Raises:
        FormatError: The suffix is not .html.
        FileError: The page cannot be written.
        MissingExtraError: matplotlib is not installed.
    """
    require_page_path(path)
    write_page(path, movements_page(judged, take, about, draw=draw))


def movements_page(
    judged: Sequence[JudgedMovement],
    take: MeshSequence,
    about: About | None = None,
    *,
    draw: bool = True,
) -> str:
    """The page that `write_movements_report` writes; arguments and errors are the same."""
    about = about or About()
    means = mean_lines(judged)
    every = means[list(means)[-1]]
    first = judged[0].evaluation
    informed = informed_methods(first)
    shape = len(take.mesh.faces) > 0
    verdict = reach_verdict(
        every, Lengths(None, about.unit), informed=informed, what="these movements"
    )
    tables = [
        error_table(lines, title, informed=informed, shape=shape) for title, lines in means.items()
    ]
    graph = Markup("")
    if draw:
        best = min(every, key=lambda line: line.lme)
        graph = graph_figure(
            lambda file: movement_graph(judged, file),
            "by-movement",
            "Largest error of each movement",
            f"One line a method over {counted(len(judged), 'movement')}: the largest error at the "
            f"recorded times. On average {best.label} is lowest, {percent(best.lme)}.",
            "A method that is lower on every movement is closer to this face; lines that cross say "
            "that the timing differs from one movement to the next.",
        )
    sections = [
        Section("compared", "What was compared", _compared(judged, take, about)),
        Section(
            "outcome",
            "The outcome",
            verdict_content(verdict, about.remarks, _SCOPE, ranking_lists(every)),
        ),
        Section(
            "errors",
            "Errors",
            joined([column_words(None, "", shape=shape, informed=informed), *tables]),
        ),
        Section("movements", "Movement by movement", joined([graph, _each(judged, informed)])),
        Section(
            "recipe",
            "To reproduce it",
            recipe(
                take,
                about,
                methods_table(first, about, "Methods with all their settings", several=True),
            ),
        ),
    ]
    subtitle = (
        f"{counted(len(first.results), 'method')} of interpolation against "
        f"{counted(len(judged), 'movement')} of a take"
    )
    return document(about.name, subtitle, sections)


def _compared(judged: Sequence[JudgedMovement], take: MeshSequence, about: About) -> Markup:
    evaluation = judged[0].evaluation
    kinds = [one.movement.kind for one in judged]
    lengths = [len(one.evaluation.truth) for one in judged]
    labels = [result.label for result in evaluation.results]
    facts: list[tuple[str, object]] = [
        ("Face", face_words(take.mesh)),
        ("Size", diameter_words(take.mesh.diameter, about.unit)),
        ("Curves", curve_words(evaluation.curves)),
        ("Take", counted(len(take), "frame")),
        (
            "Movements",
            f"{counted(kinds.count('onset'), 'onset')} and "
            f"{counted(kinds.count('offset'), 'offset')}, found in the take, of {min(lengths)} to "
            f"{max(lengths)} frames",
        ),
        ("Methods", f"{counted(len(labels), 'method')}: {', '.join(labels)}"),
    ]
    lead = element("p", about.source, class_="lead") if about.source else ""
    how = element(
        "p",
        "An onset leads from rest to an apex, an offset back. Each movement was interpolated from "
        "its own first and last frame and compared with the frames between, in per cent of its own "
        "D. There are no pictures of faces and no viewer for a whole take: evaluate one movement "
        "of a mesh for those.",
    )
    return joined([lead, fact_list(facts), how])


def _each(judged: Sequence[JudgedMovement], informed: Sequence[str]) -> Markup:
    """One line a movement: where it is, and who came closest."""
    titles = ("No.", "Kind", "Frames", "linear, LME", "Closest, LME", "Closest, free timing")
    rows = []
    for number, one in enumerate(judged, start=1):
        lines = [line for line in summaries(one.evaluation) if line.label not in informed]
        linear = next((line for line in lines if line.label == "linear"), None)
        cells = [
            one.movement.kind,
            f"{one.movement.start} to {one.movement.stop}",
            "" if linear is None else f"{100 * linear.lme:.3f}",
        ]
        for name in ("lme", "path_lme"):
            place = places(lines or summaries(one.evaluation), name)[0]
            words = "all alike" if len(place) == len(lines) > 1 else _labels(place)
            cells.append(f"{words} {100 * float(getattr(place[0], name)):.3f}")
        rows.append(
            element(
                "tr",
                element("th", str(number), scope="row", class_="name"),
                *(element("td", cell) for cell in cells),
            )
        )
    caption = "Every movement and the method closest to it; frames count from 0, errors in % of D"
    if informed:
        caption += f"; without {', '.join(informed)}, which know frames of it"
    table = element(
        "table",
        element("caption", caption),
        element("thead", element("tr", *(element("th", t, scope="col") for t in titles))),
        element("tbody", *rows),
        class_="movements",
    )
    return scrolling(table, "Every movement")


def _labels(place: Sequence[MethodSummary]) -> str:
    return ", ".join(line.label for line in place)
