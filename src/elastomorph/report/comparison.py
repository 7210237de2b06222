"""One comparison: everything found, in one page or as files in one folder.

In the page the viewer shows the methods beside the recording, to be turned and compared.

What it takes to make a report again: settings, versions, and what was compared.
"""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.draw.graphs import error_graphs, inbetween_graph, time_graphs
from elastomorph.draw.pictures import write_picture
from elastomorph.errors import ElastomorphError, FileError, MeshError
from elastomorph.evaluation import Evaluation, MethodResult, Suggestion
from elastomorph.evaluation.conclusions import reach_verdict
from elastomorph.evaluation.summary import informed_methods, summaries
from elastomorph.evaluation.words import Lengths, counted, percent
from elastomorph.io.rig_cache import installed_version
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method
from elastomorph.paths.options import options_of
from elastomorph.physics import CLOSURES
from elastomorph.physics.equation import HIGHEST_ORDER
from elastomorph.report.document import (
    About,
    Graph,
    Picture,
    Section,
    compared,
    document,
    picture_sections,
    require_page_path,
    write_page,
)
from elastomorph.report.faces import evaluation_pictures, telling_frame
from elastomorph.report.outcome import error_table, errors, outcome, ranked

_PACKAGES = {
    "elastomorph": "elastomorph",
    "numpy": "NumPy",
    "scipy": "SciPy",
    "matplotlib": "matplotlib",
    "vtk": "VTK",
    "pillow": "Pillow",
}
_POWERS = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")
_SAID = (
    *("order", "load", "material", "closure", "harmonics", "basis", "stiffness"),
    *("tolerance", "straight_within"),
)
"""Options that have words of their own."""


def recipe(
    truth: MeshSequence, evaluation: Evaluation, about: About, *, several: bool = False
) -> Section:
    """The last section of a report."""
    software = ", ".join([f"Python {platform.python_version()}", *_versions()])
    content = {
        "call": about.call,
        "software": [
            ("Versions", software),
            ("Platform", f"{platform.system()} {platform.machine()}"),
        ],
        "now": datetime.now(UTC),
        "curves": about.curves,
        "digest": _frames_digest(truth),
        "stored": not several,
        "methods": [_described(result, about, several) for result in evaluation.results],
    }
    return Section("recipe", "To reproduce it", content, appendix=True)


def _versions() -> list[str]:
    found = {name: installed_version(package) for package, name in _PACKAGES.items()}
    return [f"{name} {own}" for name, own in found.items() if own]


def _frames_digest(truth: MeshSequence) -> str:
    """SHA-256 of ``truth.frames`` as (T, V, 3) little-endian float64."""
    frames = np.ascontiguousarray(truth.frames, dtype="<f8")
    return hashlib.sha256(frames.tobytes()).hexdigest()


def _described(result: MethodResult, about: About, several: bool) -> dict[str, object]:
    """A method with all its settings and what its path takes to store."""
    morph = result.morph
    method = about.methods.get(result.label) or _named(morph)
    path, settings = _method_words(method)
    if several and isinstance(method, Morph):
        settings = "at the best frames of each"
    return {
        "label": result.label,
        "path": path,
        "settings": settings,
        "bends": len(morph.bends),
        "stored": percent(morph.bake_error) if morph.bake_error else "exact",
    }


def _named(morph: Morph) -> Method | Morph:
    """The method whose label a path carries: a label leaves no setting unsaid but the tolerance."""
    if morph.choice is not None:
        return Method("auto", straight_within=morph.choice.allowed)
    for kind in Method.known:
        for order in range(1, HIGHEST_ORDER + 1):
            for closure in CLOSURES:
                stated: dict[str, Any] = {"order": order, "closure": closure}
                method = kind(**{key: stated[key] for key in stated if kind.has(key)})
                if method.label == morph.method:
                    return method
    return morph


def _method_words(method: Method | Morph) -> tuple[str, str]:
    """What a method does, and all its settings."""
    if isinstance(method, Morph):
        inner = [
            f"{time:.4g}"
            for time in sorted({float(b) for curve in method.bend_curves for b in curve.breaks})
            if 0 < time < 1
        ]
        if method.method.startswith("through") and inner:
            return "through frames of this recording", f"at t = {', '.join(inner)}"
        return f"a finished path, made by {method.method}", ""
    settings = []
    if method.has("load"):
        settings.append(f"p(t) = {_polynomial(method.external_load.coefficients)}")
    if method.has("material"):
        material = method.material
        settings += [
            f"m = {material.mass:g}",
            f"c = {material.damping:g}",
            f"k = {material.rigidity:g}",
            f"closure {method.closure}",
            "all modes" if method.harmonics is None else f"{method.harmonics} modes",
        ]
    if method.has("basis"):
        settings += [f"basis {method.basis} on open curves", f"stiffness {method.stiffness}"]
    if method.has("tolerance"):
        settings.append(f"tolerance {percent(method.tolerance)}")
    if method.has("straight_within"):
        settings.append(f"straight within {percent(method.straight_within)}")
    others = (name for name in options_of(method) if name not in _SAID)
    settings += [f"{name.replace('_', ' ')} {getattr(method, name)}" for name in others]
    return method.path, ", ".join(settings)


def _polynomial(coefficients: Sequence[float]) -> str:
    terms = []
    for exponent, p in enumerate(coefficients, start=1):
        if p:
            power = "" if exponent == 1 else str(exponent).translate(_POWERS)
            terms.append(f"{'' if p == 1 else f'{p:g}'}t{power}")
    return " + ".join(terms)


LARGEST = 2_900_000
"""Bytes of faces in a report; beyond it fewer methods and frames are shown. Mails have limits."""
_MOST = 30_000_000
_FRAMES = (24, 12, 6)
# Bytes of a vertex in a file: once for the face with its polygons, and in each target it moves in.
_VERTEX = 40 * 4 / 3
_ROW = 16 * 4 / 3


def live_viewer(
    evaluation: Evaluation,
    title: str,
    unit: str = "",
    informed: Collection[str] = (),
    truth: str = "recorded",
) -> Section:
    """The viewer in a frame of its own, or a sentence that says why there is none.

    ``informed`` methods are the first to be left out. The section's ``page`` is empty where the
    viewer is.
    """
    page, left_out = "", []
    try:
        shown, frames = _fitting(evaluation, informed)
        page = _page(evaluation, shown, frames, title, unit, truth)
        left_out = [each.label for each in evaluation.results if each not in shown]
        reason = ""
    except FileError:  # its message names folders of this machine
        reason = "this installation came without the viewer's page"
    except ElastomorphError as error:  # a report without its viewer is better than none
        reason = str(error)
    content = {"page": page, "left_out": left_out, "reason": reason, "truth": truth}
    return Section("viewer", "Live viewer", content)


def _page(
    evaluation: Evaluation,
    shown: Sequence[MethodResult],
    frames: int,
    title: str,
    unit: str,
    truth: str,
) -> str:
    from elastomorph.viewer import evaluation_scene
    from elastomorph.viewer.page import viewer_page

    some = replace(evaluation, results=tuple(shown))
    scene = evaluation_scene(some, title=title, unit=unit, frames=frames, truth=truth, images=False)
    # Halfway, where all symmetric timings meet, says the least.
    moment = float(evaluation.truth.times[telling_frame(evaluation)])
    return viewer_page(replace(scene, start={**scene.start, "t": moment}))


def _fitting(evaluation: Evaluation, informed: Collection[str]) -> tuple[list[MethodResult], int]:
    """The methods to show and the most recorded frames, so that the page stays small."""
    if not len(evaluation.truth.mesh.faces):
        raise MeshError("markers have no surface that could be shown")
    telling, others = _by_interest(evaluation.results, informed)
    truth = evaluation.truth
    face = len(truth.mesh.vertices) * _VERTEX
    moving = int((truth.frames != truth.frames[0]).any(axis=(0, 2)).sum())
    least = sum(face + _bytes(result.morph) for result in telling)
    for frames in _FRAMES:
        size = least + face + min(frames, len(truth)) * moving * _ROW
        if size <= LARGEST:
            break
    if size > _MOST:
        raise MeshError(
            "a face of this size does not fit into a page that is mailed around. Export a method "
            "as GLB and open that with 'elastomorph view'"
        )
    chosen = list(telling)
    for result in others:
        size += face + _bytes(result.morph)
        if size > LARGEST:
            break
        chosen.append(result)
    return [result for result in evaluation.results if result in chosen], frames


def _by_interest(
    results: Sequence[MethodResult], informed: Collection[str]
) -> tuple[list[MethodResult], list[MethodResult]]:
    """What a report must show, and the rest.

    The straight line, the closest, the paper's choice, and what a rig gets unless asked otherwise.
    """
    judged = [r for r in results if r.label not in informed] or list(results)
    best = min(judged, key=lambda result: result.lme)
    telling = [r for r in results if r is best or r.label in ("linear", "beam R=2", "auto")]
    nearest = min(judged, key=lambda result: result.path_lme)
    # The ease shows what of the beam is timing alone, the nearest path what is none of it.
    rest = [r for r in results if r not in telling]
    rest.sort(key=lambda r: (r is not nearest, r.label != "ease R=2"))
    return telling, rest


def _bytes(morph: Morph) -> float:
    rows = sum(int(field.any(axis=1).sum()) for field in (morph.delta, *morph.bends))
    return rows * _ROW


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
