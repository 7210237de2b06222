"""The report of one comparison: everything found, in one page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from elastomorph.errors import FileError, FormatError
from elastomorph.evaluation import Evaluation, Suggestion
from elastomorph.evaluation.summary import informed_methods, summaries
from elastomorph.io.atomic import replacing
from elastomorph.report.about import About, Lengths
from elastomorph.report.compared import compared, counted
from elastomorph.report.content import (
    column_words,
    picture_content,
    verdict_content,
)
from elastomorph.report.document import Section, document
from elastomorph.report.error_table import error_table, ranking_lists
from elastomorph.report.faces import evaluation_pictures
from elastomorph.report.graph_section import graph_section
from elastomorph.report.live import live_viewer
from elastomorph.report.markup import joined
from elastomorph.report.picture import Picture
from elastomorph.report.recipe import methods_table, recipe
from elastomorph.report.verdict import reach_verdict

__all__ = ["report_page", "require_page_path", "write_page", "write_report"]

_ONE_MOTION = (
    "All of this was measured on one motion of one face. On other motions other methods have come "
    "closest: judge by several."
)


def write_report(
    evaluation: Evaluation,
    path: str | Path,
    about: About | None = None,
    *,
    suggestions: Sequence[Suggestion] = (),
    pictures: Sequence[Picture] = (),
    first: Sequence[Section] = (),
    faces: Sequence[Picture] | None = None,
    draw: bool = True,
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Write one self-contained HTML page about an evaluation, the whole of it or nothing.

    Args:
        evaluation: Methods compared with a recorded motion.
        path: The page, ``.html``; its folder must exist.
        about: Where the motion came from, and the settings.
        suggestions: What in-betweens would be worth, see `elastomorph.suggest_inbetweens`.
        pictures: Further pictures of faces.
        first: What the page begins with, before the comparison.
        faces: Pictures of the comparison that are drawn already, see `evaluation_pictures`.
        draw: Draw graphs, faces and the viewer; without them the page needs no extra.
        say: Told what is being done.

    Raises:
        FormatError: The suffix is not .html.
        FileError: The page cannot be written.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    require_page_path(path)
    page = report_page(
        evaluation,
        about,
        suggestions=suggestions,
        pictures=pictures,
        first=first,
        faces=faces,
        draw=draw,
        say=say,
    )
    write_page(path, page)


def report_page(
    evaluation: Evaluation,
    about: About | None = None,
    *,
    suggestions: Sequence[Suggestion] = (),
    pictures: Sequence[Picture] = (),
    first: Sequence[Section] = (),
    faces: Sequence[Picture] | None = None,
    draw: bool = True,
    say: Callable[[str], None] = lambda _: None,
) -> str:
    """The page that `write_report` writes; arguments and errors are the same."""
    about = about or About()
    informed = informed_methods(evaluation)
    sections = [
        *first,
        Section("compared", "What was compared", compared(evaluation, about, informed)),
        _outcome(evaluation, about, informed, suggestions),
        _errors(evaluation, about, informed),
    ]
    live = False
    if draw:
        say("drawing graphs")
        graphs = graph_section(evaluation, suggestions, timing_known=about.timing_known)
        if faces is None and len(evaluation.truth.mesh.faces) and about.timing_known:
            lengths = Lengths(evaluation.diameter, about.unit)
            faces = evaluation_pictures(evaluation, lengths, informed, say)
        say("adding the viewer")
        viewer, live = live_viewer(evaluation, about.name, about.unit, informed, about.truth)
        sections += [
            Section("graphs", "Curve by curve and over time", graphs),
            Section("faces", "Faces", picture_content([*(faces or ()), *pictures])),
            Section("viewer", "Live viewer", viewer),
        ]
    methods = methods_table(evaluation, about, "Methods with all their settings")
    sections.append(Section("recipe", "To reproduce it", recipe(evaluation.truth, about, methods)))
    subtitle = (
        f"{counted(len(evaluation.results), 'method')} of interpolation against "
        f"{counted(len(evaluation.truth), 'frame')}"
    )
    return document(about.name, subtitle, sections, viewer=live)


def _outcome(
    evaluation: Evaluation,
    about: About,
    informed: Sequence[str],
    suggestions: Sequence[Suggestion],
) -> Section:
    lines = summaries(evaluation)
    verdict = reach_verdict(
        lines,
        Lengths(evaluation.diameter, about.unit),
        informed=informed,
        suggestions=suggestions,
        timing_known=about.timing_known,
        what="this recording" if about.timing_known else "the known way",
    )
    rankings = ranking_lists(lines, timing_known=about.timing_known)
    content = verdict_content(verdict, about.remarks, _ONE_MOTION, rankings)
    return Section("outcome", "The outcome", content)


def _errors(evaluation: Evaluation, about: About, informed: Sequence[str]) -> Section:
    shape = len(evaluation.truth.mesh.faces) > 0
    words = column_words(evaluation.diameter, about.unit, shape=shape, informed=informed)
    table = error_table(
        summaries(evaluation),
        "Errors of each method, in % of D",
        informed=informed,
        shape=shape,
        timing_known=about.timing_known,
    )
    return Section("errors", "Errors", joined([words, table]))


def require_page_path(path: str | Path) -> None:
    """Refuse early what could not be written after a long computation.

    Raises:
        FormatError: The suffix is not .html.
        FileError: There is no such folder.
    """
    if Path(path).suffix.lower() not in (".html", ".htm"):
        raise FormatError(path, "a report is a web page; name it with the suffix .html")
    if not Path(path).resolve().parent.is_dir():
        raise FileError(
            path, f"the folder {Path(path).parent} does not exist; create it first or name another"
        )


def write_page(path: str | Path, page: str) -> None:
    """Write a finished page, the whole of it or nothing.

    Raises:
        FileError: The page cannot be written.
    """
    content = page.encode()
    with replacing(path) as file:
        file.write(content)
