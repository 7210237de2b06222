"""One comparison: everything found, in one page or as files in one folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from elastomorph.draw.graphs import error_graphs, inbetween_graph, time_graphs
from elastomorph.draw.pictures import write_picture
from elastomorph.evaluation import Evaluation, Suggestion
from elastomorph.evaluation.conclusions import reach_verdict
from elastomorph.evaluation.summary import informed_methods, summaries
from elastomorph.evaluation.words import Lengths, counted, percent
from elastomorph.report.document import Section, document, require_page_path, write_page
from elastomorph.report.faces import evaluation_pictures
from elastomorph.report.facts import About, compared
from elastomorph.report.images import Graph, Picture, picture_sections
from elastomorph.report.live import live_viewer
from elastomorph.report.outcome import error_table, errors, outcome, ranked
from elastomorph.report.recipe import recipe

__all__ = ["report_page", "write_evaluation", "write_report"]

_IN_FRONT = 2
"""Pictures that stand in front of the appendix: the ways over time, and one moment."""
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
    lines, lengths = summaries(evaluation), Lengths(evaluation.diameter, about.unit)
    verdict = reach_verdict(
        lines,
        lengths,
        informed=informed,
        suggestions=suggestions,
        timing_known=about.timing_known,
        what="this recording" if about.timing_known else "the known way",
    )
    has_polygons = len(evaluation.truth.mesh.faces) > 0
    table = error_table(
        lines,
        "Errors of each method, in % of D",
        informed=informed,
        shape=has_polygons,
        timing_known=about.timing_known,
    )
    sections = [
        *first,
        outcome(verdict, _ONE_MOTION),
        compared(evaluation, about, informed),
        errors([table], ranked(lines, about), lengths, shape=has_polygons, informed=informed),
    ]
    live = False
    if draw:
        say("drawing graphs")
        graphs = _graphs(evaluation, suggestions, timing_known=about.timing_known)
        if faces is None and has_polygons and about.timing_known:
            faces = evaluation_pictures(evaluation, lengths, informed, say)
        faces = faces or ()
        sections += picture_sections(faces[:_IN_FRONT], [*faces[_IN_FRONT:], *pictures])
        say("adding the viewer")
        viewer = live_viewer(evaluation, about.name, about.unit, informed, about.truth)
        live = bool(viewer.content["page"])
        sections.append(viewer)
        title = "Curve by curve and over time"
        sections.append(Section("graphs", title, {"graphs": graphs}, appendix=True))
    sections.append(recipe(evaluation.truth, evaluation, about))
    subtitle = (
        f"{counted(len(evaluation.results), 'method')} of interpolation against "
        f"{counted(len(evaluation.truth), 'frame')}"
    )
    return document(about.name, subtitle, sections, viewer=live)


def _graphs(
    evaluation: Evaluation, suggestions: Sequence[Suggestion], *, timing_known: bool
) -> list[Graph]:
    """Errors curve by curve and over time, and what in-betweens are worth."""
    found = [_over_time(evaluation, timing_known=timing_known)]
    if timing_known:
        found.insert(0, _by_curve(evaluation))
    if len(suggestions) > 1:
        first, last = suggestions[0], suggestions[-1]
        found.append(
            Graph.drawn(
                lambda file: inbetween_graph(suggestions, evaluation.truth.times, file),
                "inbetweens",
                "What in-betweens are worth",
                f"The largest error falls from {percent(first.lme)} without in-betweens to "
                f"{percent(last.lme)} with {len(last.frames)}.",
                "Frames of this recording as in-betweens, at the best times found, and a smooth "
                "path through them. Where the first line falls steeply, one scan more is worth "
                "more than any law.",
            )
        )
    return found


def _by_curve(evaluation: Evaluation) -> Graph:
    worst = max(evaluation.results, key=lambda result: result.lme)
    best = min(evaluation.results, key=lambda result: result.lme)
    return Graph.drawn(
        lambda file: error_graphs(evaluation, file),
        "by-curve",
        "Errors of each curve",
        f"Lines of {counted(len(evaluation.results), 'method')} over "
        f"{counted(len(evaluation.curves), 'curve')} and over time. The highest is {worst.label}, "
        f"up to {percent(worst.lme)}; the lowest peak is that of {best.label}, "
        f"{percent(best.lme)}.",
        "As in the paper's Figure 8: (a) average and (b) maximum error of each curve, and both "
        "over time (c, d). A method that is lower everywhere is closer to the recording; lines "
        "that cross say that it depends on the part of the face. Dashed lines lie on broad ones "
        "where a beam does what a straight path does.",
    )


def _over_time(evaluation: Evaluation, *, timing_known: bool) -> Graph:
    peak = max(result.lme for result in evaluation.results)
    path_peak = max(result.path_lme for result in evaluation.results)
    caption = (
        "Above at the times of the frames, below with free timing. What falls from the upper "
        "graphs to the lower was a matter of timing; what is left is the path. Free timing makes "
        "the peak of each line as low as it can be, never higher than above; beside its peak a "
        "line may lie higher."
    )
    if not timing_known:
        caption += " The times are made up here, so only the lower graphs count."
    return Graph.drawn(
        lambda file: time_graphs(evaluation, file),
        "over-time",
        "Timing and path",
        "Four graphs of error over time, one line a method: above at the times of the frames, "
        f"with a peak of {percent(peak)}; below with free timing, with a peak of "
        f"{percent(path_peak)}.",
        caption,
    )


def write_evaluation(
    evaluation: Evaluation,
    folder: Path,
    *,
    graphs: bool = True,
    faces: Sequence[Picture] = (),
    say: Callable[[str], None] = lambda _: None,
) -> list[Path]:
    """Write table, errors, graphs and ``faces`` drawn already into a folder that exists.

    Returns the files written. Graphs and faces need the extra ``demo``.
    """
    written = [folder / name for name in ("table.csv", "errors.csv", "evaluation.json")]
    evaluation.to_csv(written[0])
    evaluation.to_long_csv(written[1])
    evaluation.to_json(written[2])
    if graphs:
        say("drawing graphs")
        for name, draw in (("errors-by-curve", error_graphs), ("errors-by-time", time_graphs)):
            for suffix in (".png", ".svg"):
                written.append(folder / f"{name}{suffix}")
                draw(evaluation, written[-1])
    for picture in faces:
        written.append(folder / f"{picture.name}.png")
        write_picture(picture.image, written[-1])
    return written
