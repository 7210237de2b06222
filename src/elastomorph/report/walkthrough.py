"""The whole paper on one face: curves, in-betweens, Table 1, graphs and pictures in a folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastomorph.curves import CurveNetwork, extract_curves
from elastomorph.evaluation import DEFAULT_METHODS, Evaluation, evaluate
from elastomorph.evaluation.closure_seams import ClosureSeam, closure_seams
from elastomorph.io import write
from elastomorph.io.curve_file import write_curves
from elastomorph.mesh import Mesh
from elastomorph.morph import Morph
from elastomorph.paths import interpolate, prepare
from elastomorph.report.closures import closure_comparison
from elastomorph.report.curves_picture import curves_picture
from elastomorph.report.evaluation_files import write_evaluation, write_text
from elastomorph.report.page.faces import (
    closures_picture,
    expressions_picture,
    jaw_picture,
    sheet_picture,
)
from elastomorph.report.page.picture import Picture
from elastomorph.report.strips import expression_strip
from elastomorph.report.subject import Subject
from elastomorph.report.time_laws import time_law_graph
from elastomorph.report.walkthrough_report import write_walkthrough_report

__all__ = ["TargetFacts", "Walkthrough", "walk_through"]

_TARGET_METHODS = ("linear", "ease:2", "beam:1", "beam:2", "beam:3")
_IN_BETWEEN_TIMES = (0.25, 0.5, 0.75)


@dataclass(frozen=True)
class TargetFacts:
    """What the methods make of one target, halfway.

    Attributes:
        name: The target.
        bends: Bends of each method, in the order they were asked for.
        from_linear: Largest distance of the quadratic beam from the straight line, over D.
        from_ease: Largest distance of the quadratic beam from ``ease`` t², over D.
    """

    name: str
    bends: tuple[int, ...]
    from_linear: float
    from_ease: float


@dataclass(frozen=True, eq=False)
class Walkthrough:
    """What was found on the way.

    Attributes:
        subject: The face.
        curves: Its curves.
        evaluation: Table 1 on the recorded motion, or on the rigid parts of a rig; or none.
        seams: Each closure on the jaw, halfway.
        targets: Each target of the rig.
        written: Every file.
    """

    subject: Subject
    curves: CurveNetwork
    evaluation: Evaluation | None
    seams: list[ClosureSeam]
    targets: list[TargetFacts]
    written: list[Path]


def walk_through(
    subject: Subject,
    folder: str | Path,
    say: Callable[[str], None] = lambda _: None,
    *,
    call: str = "",
) -> Walkthrough:
    """Run the paper's experiments on a face.

    Args:
        subject: The face.
        folder: Where to write; made if it is missing.
        say: Told what is being done.
        call: The command that does it again, for the report.

    Raises:
        FileError: A file cannot be written.
        MissingExtraError: matplotlib or vtk is not installed.
    """
    place = Path(folder)
    for part in (place, place / "in-betweens"):
        part.mkdir(parents=True, exist_ok=True)
    neutral, jaw = subject.neutral, subject.targets[subject.jaw]
    say("tracing curves")
    curves = extract_curves(neutral)
    written = [place / "curves.json", place / "curves.png"]
    write_curves(written[0], curves)
    curves_picture(neutral, curves, written[1])

    evaluation = None
    motion = subject.motion
    if motion is not None:
        evaluation = evaluate(motion, curves=curves, progress=lambda name: say(f"trying {name}"))
        written += write_evaluation(evaluation, place, say=say)
    elif subject.rigid_parts is not None:
        parts = subject.rigid_parts
        evaluation = evaluate(parts.truth, curves=parts.curves(curves))
        written += write_evaluation(evaluation, place, faces=False, say=say)

    say("writing in-betweens")
    end = jaw if motion is None else motion.target
    morphs = {m: interpolate(neutral, end, m, curves=curves) for m in DEFAULT_METHODS}
    written += _write_in_betweens(neutral, morphs, place / "in-betweens")
    pictures: list[Picture] = []
    if motion is None:
        say("drawing in-betweens")
        written.append(place / "in-betweens.png")
        rows = {morph.method: morph for morph in morphs.values()}
        image = expression_strip(rows, written[-1], title=subject.jaw)
        pictures.append(jaw_picture(image, subject.jaw, list(rows)))

    say("drawing expressions")
    to = prepare(neutral, "beam:2", curves=curves)
    written += [place / "expressions.png", place / "time-laws.png", place / "closures.png"]
    expressions = {name: to(mesh) for name, mesh in subject.expressions.items()}
    image = expression_strip(expressions, written[-3])
    pictures += [expressions_picture(image, expressions), sheet_picture(expressions)]
    time_law_graph(written[-2])
    say("comparing closures")
    seams = closure_seams(neutral, jaw, curves)
    image = closure_comparison(neutral, jaw, written[-1], curves=curves)
    pictures.append(closures_picture(image, subject.jaw, seams))
    targets = list(_targets(subject, curves, say))
    written.append(write_text(place / "targets.csv", _targets_csv(targets)))
    if evaluation is not None:
        written.append(place / "report.html")
        write_walkthrough_report(
            subject, evaluation, targets, pictures, written[-1], call=call, say=say
        )
    return Walkthrough(subject, curves, evaluation, seams, targets, written)


def _write_in_betweens(neutral: Mesh, morphs: dict[str, Morph], folder: Path) -> list[Path]:
    written = []
    for method, morph in morphs.items():
        for time in _IN_BETWEEN_TIMES:
            file = folder / f"{method.replace(':', '-')} t={time:g}.obj"
            write(file, neutral.with_vertices(morph.at(time)))
            written.append(file)
    return written


def _targets(
    subject: Subject, curves: CurveNetwork, say: Callable[[str], None]
) -> Sequence[TargetFacts]:
    neutral = subject.neutral
    prepared = {method: prepare(neutral, method, curves=curves) for method in _TARGET_METHODS}
    facts = []
    for name, target in subject.targets.items():
        say(f"interpolating {name}")
        morphs = {method: to(target) for method, to in prepared.items()}
        beam = morphs["beam:2"].at(0.5)
        distance = {
            other: float(np.linalg.norm(beam - morphs[other].at(0.5), axis=1).max())
            / neutral.diameter
            for other in ("linear", "ease:2")
        }
        bends = tuple(len(morph.bends) for morph in morphs.values())
        facts.append(TargetFacts(name, bends, distance["linear"], distance["ease:2"]))
    return facts


def _targets_csv(targets: Sequence[TargetFacts]) -> str:
    header = ["target", *(f"bends {method}" for method in _TARGET_METHODS)]
    lines = [",".join([*header, "beam:2 from linear", "beam:2 from ease:2"])]
    for facts in targets:
        numbers = [*map(str, facts.bends), f"{facts.from_linear:.9g}", f"{facts.from_ease:.9g}"]
        lines.append(",".join([facts.name, *numbers]))
    return "\n".join(lines) + "\n"
