"""The report of the walkthrough: what each target needs, its comparison, and what it drew."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from elastomorph.evaluation import Evaluation, suggest_inbetweens
from elastomorph.evaluation.target_paths import TargetPaths
from elastomorph.evaluation.words import SPACE, counted, percent, significant
from elastomorph.paths.auto import INBETWEEN_PAYS
from elastomorph.report import About, Picture, write_report
from elastomorph.report.document import Section, document, write_page
from elastomorph.report.hinge import Jaw, hinge_section
from elastomorph.report.subject import Subject

__all__ = ["BeamTiming", "beam_words", "truth_words", "write_walkthrough_report"]

_MOST_INBETWEENS = 3


@dataclass(frozen=True)
class BeamTiming:
    """How far the quadratic beam takes another way than the ease t², at t = 0.5.

    Attributes:
        name: The target on which they part most.
        distance: By how much, as a fraction of D.
    """

    name: str
    distance: float


def write_walkthrough_report(
    subject: Subject,
    paths: TargetPaths,
    evaluation: Evaluation | None,
    jaw: Jaw | None,
    beam: BeamTiming,
    pictures: Sequence[Picture],
    path: Path,
    *,
    call: str = "",
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Write the page of a walkthrough."""
    first = [_targets(paths, subject.unit)]
    if jaw is not None:
        first.append(hinge_section(jaw, subject.jaw, subject.unit))
    if evaluation is None:
        faces = Section("faces", "Faces", {"pictures": pictures})
        sections = [*first, *([faces] if pictures else [])]
        write_page(path, document(subject.name, "What its targets need", sections))
        return
    suggestions = []
    if subject.take is not None:
        say("looking for the best in-betweens")
        suggestions = suggest_inbetweens(subject.take, _MOST_INBETWEENS, curves=evaluation.curves)
    about = About(
        subject.name,
        source=truth_words(subject),
        unit=subject.unit,
        call=call,
        timing_known=subject.take is not None,
        remarks=(beam_words(beam, len(subject.targets)),),
    )
    write_report(
        evaluation,
        path,
        about,
        suggestions=suggestions,
        pictures=pictures,
        first=first,
        faces=(),
        say=say,
    )


def _targets(paths: TargetPaths, unit: str) -> Section:
    """What a rigger reads first: which way each target needs, and what that costs."""
    straight = [target for target in paths.targets if target.choice.straight]
    allowed = max((target.choice.allowed for target in paths.targets), default=0.0)
    content = {
        "summary": paths.summary,
        "allowed": f"{100 * allowed:g}",
        "pays": f"{100 * INBETWEEN_PAYS:g}",
        "extent": f"{significant(paths.extent)}{SPACE}{unit or 'units'}",
        "bent": [target for target in paths.targets if not target.choice.straight],
        "straight": straight,
        "straight_words": (
            f"{counted(len(straight), 'target')} for which the straight line is enough"
        ),
    }
    return Section("targets", "What each target needs", content)


def truth_words(subject: Subject) -> str:
    """What the methods are compared with, in a sentence or two."""
    parts = subject.rigid_parts
    if subject.take is not None or parts is None:
        return (
            "The recorded motion is one of 11 poses that an anatomical model makes, without the "
            "physics of the beams: the jaw turns about its hinge, the lids about the eyes."
        )
    degrees = math.degrees(parts.screw.angle)
    return (
        f"Compared are the {parts.components} parts ({len(parts.vertices):,} vertices) that turn "
        f"rigidly with {subject.jaw}, by {degrees:.1f}°, on paths of the whole face, whose D all "
        "errors are in. Their arc is known, their timing is not: only errors with free timing "
        "count."
    )


def beam_words(beam: BeamTiming, targets: int) -> str:
    """How far the quadratic beam takes another way than the ease of its own timing."""
    return (
        f"Of {targets} targets, the quadratic beam differs from the ease t² by at most "
        f"{percent(beam.distance)} ({beam.name}, t = 0.5): with these materials it changes when a "
        "shape arrives, hardly the way it takes."
    )
