"""One line a method: the numbers of a table, and what they amount to in words."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from elastomorph.evaluation.results import Evaluation

__all__ = [
    "SAME",
    "MethodSummary",
    "conclusions",
    "informed_methods",
    "mean_summaries",
    "places",
    "rankings",
    "same",
    "summaries",
]

# Two errors are called the same when they differ by less than one part in a hundred, or by less
# than 0.001 % of D, the last digit of the table.
SAME = 0.01
_LAST_DIGIT = 1e-5


@dataclass(frozen=True)
class MethodSummary:
    """The line of one method; errors and seam are fractions of D."""

    label: str
    lme: float
    lae: float
    mean_lme: float
    mean_lae: float
    path_lme: float
    path_lae: float
    path_mean_lme: float
    path_mean_lae: float
    seam: float
    flips: float
    stretch: float


_NUMBERS = tuple(field.name for field in fields(MethodSummary) if field.name != "label")


def summaries(evaluation: Evaluation) -> list[MethodSummary]:
    """The lines of one evaluation, in the order of its methods."""
    return [
        MethodSummary(result.label, **{name: getattr(result, name) for name in _NUMBERS})
        for result in evaluation.results
    ]


def mean_summaries(evaluations: Sequence[Evaluation]) -> list[MethodSummary]:
    """The mean of each number over several motions, of the methods that all of them have.

    A motion of few frames leaves no room for scanned in-betweens, so not every method is
    everywhere.
    """
    every = [{line.label: line for line in summaries(each)} for each in evaluations]
    shared = [label for label in every[0] if all(label in lines for lines in every)]
    return [
        MethodSummary(
            label,
            **{
                name: float(np.mean([getattr(lines[label], name) for lines in every]))
                for name in _NUMBERS
            },
        )
        for label in shared
    ]


def same(first: float, second: float) -> bool:
    """Whether two errors are the same for all that a table shows."""
    return abs(first - second) <= max(SAME * max(first, second), _LAST_DIGIT)


def informed_methods(evaluation: Evaluation) -> list[str]:
    """The methods that were given frames of the recording besides its ends."""
    return [r.label for r in evaluation.results if r.morph.method.startswith("through ")]


def conclusions(lines: Sequence[MethodSummary], informed: Collection[str] = ()) -> list[str]:
    """What a table shows, in sentences computed from its numbers.

    The method of smallest LME is compared with the one labelled ``linear``. Its win is one of
    timing alone if its path, with free timing, is no closer to the motion than the straight line.

    Args:
        lines: The methods.
        informed: Those that were given frames of the recording: they win nothing against methods
            that know its ends only, and have a sentence of their own.
    """
    told = [line for line in lines if line.label in informed]
    judged = [line for line in lines if line.label not in informed]
    said = _conclusions(judged) if judged else []
    if told:
        each = " and ".join(f"{line.label} ({_percent(line.lme)} of D)" for line in told)
        said.append(
            f"{each} passed through frames of this very recording: what scanned in-betweens are "
            "worth, not a win."
        )
    return said


def _conclusions(lines: Sequence[MethodSummary]) -> list[str]:
    linear = next((line for line in lines if line.label == "linear"), None)
    best = min(lines, key=lambda line: line.lme)
    if linear is None or len(lines) == 1:
        return [f"Smallest LME: {best.label}, {_percent(best.lme)} of D."]
    if linear.path_lme < linear.lme and not same(linear.path_lme, linear.lme):
        said = [
            f"Free timing brings linear from {_percent(linear.lme)} to "
            f"{_percent(linear.path_lme)} of D (LME): that much is a matter of when, not where."
        ]
    else:
        said = [
            f"Free timing does not bring linear closer ({_percent(linear.lme)} at the captured "
            f"times, {_percent(linear.path_lme)} with it, LME): its error is one of path."
        ]
    if best is linear or same(best.lme, linear.lme):
        return ["No method is closer than linear at the captured times (LME).", *said]
    sharing = [
        line.label
        for line in lines
        if line.label.startswith("ease") and line is not best and same(line.lme, best.lme)
    ]
    shared = f" As close at the captured times: {', '.join(sharing)}." if sharing else ""
    win = (
        f"{best.label} has the smallest LME, {_percent(best.lme)} of D against "
        f"{_percent(linear.lme)} for linear"
    )
    closer = [
        name
        for name, ours, theirs in (
            ("LME", best.path_lme, linear.path_lme),
            ("LAE", best.path_lae, linear.path_lae),
        )
        if ours < theirs and not same(ours, theirs)
    ]
    if not closer:
        reason = (
            "with free timing its path is no closer than the straight line "
            f"({_percent(best.path_lme)} against {_percent(linear.path_lme)})"
        )
        return [f"{win}: a win of timing alone, for {reason}.{shared}", *said]
    path = (
        "; with free timing its path too is closer than the straight line in "
        f"{' and '.join(closer)} (LME {_percent(best.path_lme)} against "
        f"{_percent(linear.path_lme)}, LAE {_percent(best.path_lae)} against "
        f"{_percent(linear.path_lae)})"
    )
    return [f"{win}{path}.{shared}", *said]


def _percent(fraction: float) -> str:
    """An error as in the table, such as "1.376 %"."""
    return f"{100 * fraction:.3f} %"


def rankings(lines: Sequence[MethodSummary]) -> list[str]:
    """The methods in the order of their errors: as timed, and with free timing.

    Methods that read the same in a table share a place.
    """
    said = []
    for what, name in (("At the captured times", "lme"), ("With free timing", "path_lme")):
        order = "; ".join(
            f"{i}. {', '.join(line.label for line in place)}"
            for i, place in enumerate(places(lines, name), start=1)
        )
        said.append(f"{what} (LME): {order}.")
    return said


def places(lines: Sequence[MethodSummary], name: str) -> list[list[MethodSummary]]:
    """The methods by rising error, those that read the same in one place.

    Args:
        lines: The methods.
        name: The error, a field of `MethodSummary`.
    """
    found: list[list[MethodSummary]] = []
    for line in sorted(lines, key=lambda line: float(getattr(line, name))):
        if found and same(float(getattr(line, name)), float(getattr(found[-1][0], name))):
            found[-1].append(line)
        else:
            found.append([line])
    return found
