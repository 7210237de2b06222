"""The report of a long take: every movement in it judged, and their means."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from elastomorph.draw.graphs import movement_graph
from elastomorph.evaluation.conclusions import reach_verdict
from elastomorph.evaluation.movements import JudgedMovement, coverage_of, mean_lines
from elastomorph.evaluation.summary import MethodSummary, informed_methods, places, summaries
from elastomorph.evaluation.words import Lengths, counted, percent
from elastomorph.model.sequence import MeshSequence
from elastomorph.report.comparison import recipe
from elastomorph.report.document import (
    About,
    Graph,
    Section,
    curve_words,
    diameter_words,
    document,
    face_words,
    method_labels,
    require_page_path,
    write_page,
)
from elastomorph.report.outcome import error_table, errors, outcome, ranked

_SCOPE = (
    "Errors are means of the movements of one take. On other faces and takes other methods "
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
    lengths = Lengths(None, about.unit)
    verdict = reach_verdict(every, lengths, informed=informed, what="these movements")
    tables = [
        error_table(lines, title, informed=informed, shape=shape) for title, lines in means.items()
    ]
    sections = [
        _compared(judged, take, about),
        outcome(verdict, _SCOPE),
        errors(tables, ranked(every, about), lengths, shape=shape, informed=informed),
        _each(judged, informed, [_graph(judged, every)] if draw else []),
        recipe(take, first, about, several=True),
    ]
    subtitle = (
        f"{counted(len(first.results), 'method')} of interpolation against "
        f"{counted(len(judged), 'movement')} of a take"
    )
    return document(about.name, subtitle, sections)


def _compared(judged: Sequence[JudgedMovement], take: MeshSequence, about: About) -> Section:
    evaluation = judged[0].evaluation
    kinds = [one.movement.kind for one in judged]
    lengths = [len(one.evaluation.truth) for one in judged]
    found = (
        f"{counted(kinds.count('onset'), 'onset')} and {counted(kinds.count('offset'), 'offset')}, "
        f"found in the take, of {min(lengths)} to {max(lengths)} frames"
    )
    facts = [
        ("Face", face_words(take.mesh)),
        ("Size", diameter_words(take.mesh.diameter, about.unit)),
        ("Curves", curve_words(evaluation.curves)),
        ("Take", counted(len(take), "frame")),
        ("Movements", found),
        ("Methods", method_labels(evaluation)),
    ]
    words = coverage_of(judged)
    if words:
        facts.append(("Confidence", words))
    how = (
        "An onset leads from rest to an apex, an offset back. Each movement was interpolated from "
        "its own first and last frame and compared with the frames between, in per cent of its own "
        "D. There are no pictures of faces and no viewer for a whole take: evaluate one movement "
        "of a mesh for those."
    )
    content = {"source": about.source, "facts": facts, "how": how, "remarks": about.remarks}
    return Section("compared", "What was compared", content, appendix=True)


def _graph(judged: Sequence[JudgedMovement], means: Sequence[MethodSummary]) -> Graph:
    best = min(means, key=lambda line: line.lme)
    return Graph.drawn(
        lambda file: movement_graph(judged, file),
        "by-movement",
        "Largest error of each movement",
        f"One line a method over {counted(len(judged), 'movement')}: the largest error at the "
        f"recorded times. On average {best.label} is lowest, {percent(best.lme)}.",
        "A method that is lower on every movement is closer to this face; lines that cross say "
        "that the timing differs from one movement to the next.",
    )


def _each(
    judged: Sequence[JudgedMovement], informed: Sequence[str], graphs: Sequence[Graph]
) -> Section:
    """One line a movement: where it is, and who came closest."""
    caption = "Every movement and the method closest to it; frames count from 0, errors in % of D"
    if informed:
        caption += f"; without {', '.join(informed)}, which know frames of it"
    content = {
        "graphs": graphs,
        "caption": caption,
        "heads": (
            "No.",
            "Kind",
            "Frames",
            "linear, LME",
            "Closest, LME",
            "Closest, free timing",
        ),
        "rows": [(number, _cells(one, informed)) for number, one in enumerate(judged, start=1)],
    }
    return Section("movements", "Movement by movement", content)


def _cells(one: JudgedMovement, informed: Sequence[str]) -> list[str]:
    every = summaries(one.evaluation)
    lines = [line for line in every if line.label not in informed]
    linear = next((line for line in lines if line.label == "linear"), None)
    cells = [
        one.movement.kind,
        f"{one.movement.start} to {one.movement.stop}",
        "" if linear is None else f"{100 * linear.lme:.3f}",
    ]
    for error in ("lme", "path_lme"):
        place = places(lines or every, error)[0]
        labels = ", ".join(line.label for line in place)
        words = "all alike" if len(place) == len(lines) > 1 else labels
        cells.append(f"{words} {100 * float(getattr(place[0], error)):.3f}")
    return cells
