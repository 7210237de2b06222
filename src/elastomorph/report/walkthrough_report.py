"""The report of the walkthrough: its comparison, and what it drew of the whole face."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from elastomorph.evaluation import DEFAULT_METHODS, Evaluation, suggest_inbetweens
from elastomorph.paths import Method
from elastomorph.report.page import About, Picture, write_report
from elastomorph.report.page.about import percent

if TYPE_CHECKING:
    from elastomorph.report.subject import Subject
    from elastomorph.report.walkthrough import TargetFacts

__all__ = ["motion_words", "target_words", "write_walkthrough_report"]

_MOST_INBETWEENS = 3


def write_walkthrough_report(
    subject: Subject,
    evaluation: Evaluation,
    targets: Sequence[TargetFacts],
    pictures: Sequence[Picture],
    path: Path,
    *,
    call: str = "",
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Write the page of a walkthrough.

    Args:
        subject: The face.
        evaluation: What the methods were compared with.
        targets: What they make of each target.
        pictures: What was drawn of the whole face.
        path: The page.
        call: The command that makes it again.
        say: Told what is being done.

    Raises:
        FileError: The page cannot be written.
        MissingExtraError: vtk, matplotlib or Pillow is not installed.
    """
    recorded = subject.motion is not None
    suggestions = (
        suggest_inbetweens(evaluation.truth, _MOST_INBETWEENS, curves=evaluation.curves)
        if recorded
        else []
    )
    methods = [Method.parse(text) for text in DEFAULT_METHODS]
    about = About(
        subject.name,
        source=motion_words(subject),
        unit=subject.unit,
        call=call,
        methods={method.label: method for method in methods},
        timing_known=recorded,
        remarks=(target_words(targets),),
    )
    write_report(evaluation, path, about, suggestions=suggestions, pictures=pictures, say=say)


def motion_words(subject: Subject) -> str:
    """What the methods are compared with, in a sentence or two."""
    parts = subject.rigid_parts
    if subject.motion is not None or parts is None:
        return (
            "The recorded motion is one of 11 poses that an anatomical model makes, without the "
            "physics of the beams: the jaw turns about its hinge, the lids about the eyes."
        )
    degrees = math.degrees(parts.screw.angle)
    return (
        f"Compared are the {parts.components} parts ({len(parts.vertices):,} vertices, their own "
        f"D) that turn rigidly with {subject.jaw}, by {degrees:.1f}°. Their arc is known, their "
        "timing is not: only errors with free timing count."
    )


def target_words(targets: Sequence[TargetFacts]) -> str:
    """How far the quadratic beam takes another way than the ease of its own timing."""
    farthest = max(targets, key=lambda facts: facts.from_ease)
    return (
        f"Of {len(targets)} targets, the quadratic beam differs from the ease t² by at most "
        f"{percent(farthest.from_ease)} ({farthest.name}, t = 0.5): with these materials it "
        "changes when a shape arrives, hardly the way it takes."
    )
