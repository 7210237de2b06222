"""One line a method: the numbers of a table, who won, and the places."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import asdict, dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from elastomorph.evaluation.results import Evaluation

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
    unmasked_lme: float | None = None
    unmasked_lae: float | None = None

    def facts(self) -> dict[str, str | float]:
        """The line as JSON and tables have it: without what was not measured."""
        return {name: value for name, value in asdict(self).items() if value is not None}


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
            **{name: _mean([getattr(lines[label], name) for lines in every]) for name in _NUMBERS},
        )
        for label in shared
    ]


def _mean(values: Sequence[float | None]) -> Any:
    """The mean of a number over several motions; None where it was not measured in all."""
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if len(known) == len(values) else None


def same(first: float, second: float) -> bool:
    """Whether two errors are the same for all that a table shows."""
    return abs(first - second) <= max(SAME * max(first, second), _LAST_DIGIT)


def informed_methods(evaluation: Evaluation) -> list[str]:
    """The methods that were given frames of the recording besides its ends."""
    return [result.label for result in evaluation.results if result.informed]


@dataclass(frozen=True)
class Outcome:
    """Who won a comparison.

    The method of smallest error is compared with the one labelled ``linear``, the yardstick. A win
    by LME is one of timing alone if the winner's path, with free timing, is no closer to the motion
    than the straight line.
    """

    judged: tuple[MethodSummary, ...]  # The methods that are ranked, at least one
    # Those that were given frames of the recording: they win nothing against methods that know
    # its ends only.
    informed: tuple[MethodSummary, ...]
    error: str  # The error compared: ``lme``, or ``path_lme`` where no times are known
    best: MethodSummary  # The method of smallest error
    linear: MethodSummary | None  # The yardstick, if it is there
    won: bool  # Whether the best method beats the yardstick by more than a table shows
    # The errors with free timing, ``path_lme`` and ``path_lae``, in which it does.
    closer: tuple[str, ...]
    timing: bool  # Whether free timing brings the yardstick closer

    @classmethod
    def of(
        cls, lines: Sequence[MethodSummary], informed: Collection[str] = (), error: str = "lme"
    ) -> Outcome:
        """Judge methods; where all of them were informed, these are ranked."""
        told = tuple(line for line in lines if line.label in informed)
        judged = tuple(line for line in lines if line.label not in informed) or told
        best = min(judged, key=lambda line: float(getattr(line, error)))
        linear = next((line for line in judged if line.label == "linear"), None)
        if linear is None:
            return cls(judged, told, error, best, None, False, (), False)
        won = best is not linear and not _alike(best, linear, error)
        closer = tuple(n for n in ("path_lme", "path_lae") if _is_less(best, linear, n))
        timing = linear.path_lme < linear.lme and not same(linear.path_lme, linear.lme)
        return cls(judged, told, error, best, linear, won, closer, timing)

    @property
    def timing_alone(self) -> bool:
        """Whether the best method beats the yardstick by nothing but its timing."""
        return self.won and not self.closer and self.error == "lme"

    @property
    def compared(self) -> bool:
        """Whether there is a yardstick, and anything to compare with it."""
        return self.linear is not None and len(self.judged) > 1

    def alike(self, line: MethodSummary) -> list[str]:
        """Labels of the other methods whose error reads the same as that of one."""
        return [
            other.label
            for other in self.judged
            if other is not line and _alike(other, line, self.error)
        ]

    @property
    def eases(self) -> list[str]:
        """Straight lines at another pace that come as close as the best."""
        return [label for label in self.alike(self.best) if label.startswith("ease")]


def _alike(first: MethodSummary, second: MethodSummary, error: str) -> bool:
    return same(float(getattr(first, error)), float(getattr(second, error)))


def _is_less(first: MethodSummary, second: MethodSummary, error: str) -> bool:
    less = float(getattr(first, error)) < float(getattr(second, error))
    return less and not _alike(first, second, error)


def places(lines: Sequence[MethodSummary], name: str) -> list[list[MethodSummary]]:
    """The methods by rising error, the field `name`; those that read the same are in one place."""
    found: list[list[MethodSummary]] = []
    for line in sorted(lines, key=lambda line: float(getattr(line, name))):
        if found and same(float(getattr(line, name)), float(getattr(found[-1][0], name))):
            found[-1].append(line)
        else:
            found.append([line])
    return found
