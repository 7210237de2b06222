"""The whole paper on one face, and what goes beyond it: paths, errors, graphs and pictures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.draw.comparisons import closure_comparison
from elastomorph.draw.curves_picture import curves_picture
from elastomorph.draw.hinge import eyelid_graph, hinge_faces, hinge_graph
from elastomorph.draw.time_laws import time_law_graph
from elastomorph.evaluation import DEFAULT_METHODS, Evaluation, evaluate, every_method
from elastomorph.evaluation.rigid_bodies import HingeError, find_eyelid, find_hinge, hinge_errors
from elastomorph.evaluation.shape import ClosureSeam, closure_seams
from elastomorph.evaluation.summary import informed_methods
from elastomorph.evaluation.target_paths import TargetPaths, target_paths
from elastomorph.evaluation.words import Lengths
from elastomorph.io import write
from elastomorph.io.atomic import made_folder, replacing
from elastomorph.io.vertex_lists import write_curves
from elastomorph.model.morph import Morph
from elastomorph.paths import Method, interpolate, prepare
from elastomorph.report.advice import TargetPictures, advice, targets_table
from elastomorph.report.comparison import write_evaluation
from elastomorph.report.document import Section
from elastomorph.report.faces import evaluation_pictures
from elastomorph.report.hinge import Jaw, eyelid_section, hinge_section
from elastomorph.report.images import Picture
from elastomorph.report.outcome import table_1_section
from elastomorph.report.subject import Subject
from elastomorph.report.walkthrough_page import (
    BeamTiming,
    closures_picture,
    expressions_picture,
    jaw_picture,
    sheet_picture,
    write_walkthrough_report,
)
from elastomorph.rig.performance.naming import shape_of

__all__ = ["Walkthrough", "walk_through"]

_JAW_METHODS = ("linear", "arc", "rotation", "auto")
_LID_METHODS = ("linear", "beam:2", "auto")
_IN_BETWEEN_TIMES = (0.25, 0.5, 0.75)


@dataclass(frozen=True, eq=False)
class Walkthrough:
    """What was found on the way.

    Attributes:
        subject: The face.
        curves: Its curves.
        paths: What each target needs.
        hinge: How far methods leave the arc of the jaw; none where nothing turns rigidly.
        eyelid: How far a lid sinks towards the eye on its way, by method, as fractions of D; none
            without lid and eyeball.
        evaluation: Table 1 on the recorded motion, or on the rigid parts of a rig; or none.
        seams: Each closure on the jaw, halfway.
        beam: Where the quadratic beam differs most from the ease.
        written: Every file.
    """

    subject: Subject
    curves: CurveNetwork
    paths: TargetPaths
    hinge: list[HingeError]
    eyelid: dict[str, float]
    evaluation: Evaluation | None
    seams: list[ClosureSeam]
    beam: BeamTiming
    written: list[Path]


def walk_through(
    subject: Subject,
    folder: str | Path,
    say: Callable[[str], None] = lambda _: None,
    *,
    call: str = "",
) -> Walkthrough:
    """Run the paper's experiments on a face, beside the methods that turn what turns."""
    place = _Folder(Path(folder))
    neutral, jaw = subject.neutral, subject.targets[subject.jaw]
    say("tracing curves")
    curves = extract_curves(neutral)
    write_curves(place.file("curves.json"), curves)
    curves_picture(neutral, curves, place.file("curves.png"))
    with TargetPictures(subject) as cards:
        paths = target_paths(neutral, subject.targets, progress=say, seen=cards.draw)
    with replacing(place.file("targets.csv")) as table:
        table.write(_targets_csv(paths).encode())

    say(f"interpolating {subject.jaw} by every method")
    morphs = _every_morph(subject, curves)
    evaluation = _compared(subject, curves, morphs, say)
    faces: list[Picture] = []
    if evaluation is not None:
        if subject.take is not None:  # the parts of a rig alone are no face to look at
            lengths = Lengths(evaluation.diameter, subject.unit)
            faces = evaluation_pictures(evaluation, lengths, informed_methods(evaluation), say)
        place.written += write_evaluation(evaluation, place.path, faces=faces, say=say)
        morphs = morphs or {result.label: result.morph for result in evaluation.results}
    say("writing in-betweens")
    for label, morph in morphs.items():
        for t in _IN_BETWEEN_TIMES:
            write(
                place.file(f"in-betweens/{label} t={t:g}.obj"), neutral.with_vertices(morph.at(t))
            )
    turning = _jaw_on_its_hinge(subject, morphs, place, say)
    if subject.take is None:
        say(f"drawing {subject.jaw}")
        shown = {label: morphs[label] for label in ("linear", "beam R=2", "auto")}
        faces.append(jaw_picture(shown, subject.jaw, place.file("in-betweens.png")))
    more = _expressions(subject, place, say)
    say("comparing closures")
    seams = closure_seams(neutral, jaw, curves)
    image = closure_comparison(neutral, jaw, place.file("closures.png"), curves=curves)
    more.append(closures_picture(image, subject.jaw, seams))
    beam = _beam_timing(subject, curves)
    first = [advice(paths, cards.drawn, subject)]
    if turning is not None:
        first.append(hinge_section(turning, subject.jaw, subject.unit))
    dips, lid = _lid_on_its_eye(subject, curves, place, say)
    paper = None if subject.take is None or evaluation is None else table_1_section(evaluation)
    first += [each for each in (lid, targets_table(paths, subject.unit), paper) if each is not None]
    found = (subject, evaluation, first, beam, faces, more)
    write_walkthrough_report(*found, place.file("report.html"), call=call, say=say)
    hinge = [] if turning is None else turning.errors
    return Walkthrough(subject, curves, paths, hinge, dips, evaluation, seams, beam, place.written)


class _Folder:
    """Where a walkthrough writes, and what it has written."""

    def __init__(self, path: Path) -> None:
        for folder in (path, path / "in-betweens"):
            made_folder(folder)
        self.path = path
        self.written: list[Path] = []

    def file(self, name: str) -> Path:
        self.written.append(self.path / name)
        return self.written[-1]


def _every_morph(subject: Subject, curves: CurveNetwork) -> dict[str, Morph]:
    """The jaw of a rig by every method; nothing for a recorded motion, which has its own ends."""
    if subject.take is not None:
        return {}
    neutral, jaw = subject.neutral, subject.targets[subject.jaw]
    names = (*DEFAULT_METHODS, "plate:2", "arc", "rotation", "auto")
    methods = [Method.parse(name) for name in names]
    return {each.label: interpolate(neutral, jaw, each, curves=curves) for each in methods}


def _compared(
    subject: Subject,
    curves: CurveNetwork,
    morphs: Mapping[str, Morph],
    say: Callable[[str], None],
) -> Evaluation | None:
    """Every method against the recorded motion, or against the known arc of rigid parts."""
    if subject.take is not None:
        methods = every_method(subject.take, curves, progress=say)
        say("comparing them with the recorded motion")
        return evaluate(subject.take, methods, curves)
    parts = subject.rigid_parts
    if parts is None:
        return None
    say("comparing them with the known arc")
    # Paths of the whole face, of which the parts are looked at: what a rigger would get.
    of_parts = {label: parts.restricted(morph) for label, morph in morphs.items()}
    return evaluate(
        parts.truth, of_parts, parts.curves(curves), extent=subject.neutral.diameter or None
    )


def _jaw_on_its_hinge(
    subject: Subject, known: Mapping[str, Morph], place: _Folder, say: Callable[[str], None]
) -> Jaw | None:
    parts = subject.rigid_parts
    if parts is None:
        return None
    say("measuring the jaw on its hinge")
    neutral, jaw = subject.neutral, subject.targets[subject.jaw]
    hinge = find_hinge(neutral, jaw, parts)
    if subject.take is None:  # its methods were tried on this very jaw
        morphs = {name: known[name] for name in _JAW_METHODS}
    else:
        morphs = {name: interpolate(neutral, jaw, name) for name in _JAW_METHODS}
    image = hinge_faces(hinge, morphs, place.file("hinge.png"))
    hinge_graph(hinge, morphs, place.file("hinge-graph.png"), subject.unit)
    return Jaw(hinge, morphs, hinge_errors(hinge, morphs), image)


def _lid_on_its_eye(
    subject: Subject, curves: CurveNetwork, place: _Folder, say: Callable[[str], None]
) -> tuple[dict[str, float], Section | None]:
    """How far a lid sinks towards the eye on its way over it, and what the report says of it."""
    name = next((each for each in subject.targets if shape_of(each) == "eyeBlinkLeft"), None)
    lid = None if name is None else find_eyelid(subject.neutral, subject.targets[name])
    if name is None or lid is None:
        return {}, None
    say("measuring the eyelid on the eyeball")
    methods = [Method.parse(each) for each in _LID_METHODS]
    neutral, target = subject.neutral, subject.targets[name]
    morphs = {each.label: interpolate(neutral, target, each, curves=curves) for each in methods}
    eyelid_graph(lid, morphs, place.file("eyelid-graph.png"), subject.unit)
    dips = {label: lid.dip(morph) for label, morph in morphs.items()}
    return dips, eyelid_section(lid, morphs, dips, name, subject.unit)


def _expressions(subject: Subject, place: _Folder, say: Callable[[str], None]) -> list[Picture]:
    say("drawing expressions")
    to = prepare(subject.neutral, "auto", targets=list(subject.expressions.values()))
    morphs = {name: to(mesh) for name, mesh in subject.expressions.items()}
    growing = expressions_picture(morphs, place.file("expressions.png"))
    time_law_graph(place.file("time-laws.png"))
    say("drawing blended faces")
    return [growing, sheet_picture(morphs, place.file("blended-faces.png"))]


def _beam_timing(subject: Subject, curves: CurveNetwork) -> BeamTiming:
    neutral = subject.neutral
    beam, ease = (prepare(neutral, name, curves=curves) for name in ("beam:2", "ease:2"))
    found = []
    for name, target in subject.targets.items():
        apart = np.linalg.norm(beam(target).at(0.5) - ease(target).at(0.5), axis=1)
        found.append(BeamTiming(name, float(apart.max()) / (neutral.diameter or 1.0)))
    return max(found, key=lambda each: each.distance)


def _targets_csv(paths: TargetPaths) -> str:
    lines = ["target,needs,off the straight line,allowed,bends,bytes,bake error,flips"]
    for path in paths.targets:
        choice = path.choice
        numbers = f"{choice.distance:.9g},{choice.allowed:.9g},{path.bends},{path.bytes}"
        lines.append(f"{path.name},{path.words},{numbers},{path.bake_error:.9g},{path.flips}")
    return "\n".join(lines) + "\n"
