"""What was learned from a recording: a path, and how well it follows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from elastomorph.evaluation.curve_errors import CurveErrors, CurveVertices, frame_errors
from elastomorph.fitting.path_fit import PathFit, Splines
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence
from elastomorph.rig.timing import Timing, linear

_NONE = np.zeros((0, 0))
# A path carries over if it makes errors of recordings left out so many times smaller.
_CARRIES = 1.01
_PARTS = (1.0, 0.5, 0.25, 0.0)

Found = TypeVar("Found")


@dataclass(frozen=True, eq=False)
class PathErrors(CurveErrors):
    """The errors of a path on a recording, as fractions of D.

    Attributes:
        average: (T,) largest E_A over the curves in each frame.
        maximum: (T,) largest E_M over the curves in each frame.
    """

    average: NDArray[np.float64]
    maximum: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        path: Morph,
        take: MeshSequence,
        moments: NDArray[np.float64],
        along: CurveVertices,
        counted: NDArray[np.bool_] | None = None,
    ) -> PathErrors:
        """Those of a path whose (T,) moments the frames of a recording are compared with."""
        return cls(*frame_errors(path, take, moments, along, counted))

    @classmethod
    def joined(cls, several: Sequence[PathErrors]) -> PathErrors:
        """Those of several recordings, one after the other."""
        parts = [(errors.average, errors.maximum) for errors in several]
        return cls(*map(np.concatenate, zip(*parts, strict=True)))

    def part_of(self, others: PathErrors) -> float:
        """How large the LME or LAE is beside another's, the larger of the two; 0 of nothing."""
        pairs = ((self.lme, others.lme), (self.lae, others.lae))
        return max((own / other if other else np.inf) if own else 0.0 for own, other in pairs)


_NO_ERRORS = PathErrors(_NONE, _NONE)


@dataclass(frozen=True, eq=False)
class Repetition:
    """One of several recordings that one path was learned from, with its own ends and timing.

    Attributes:
        timing: When it is where on the path.
        errors: Those of the path between its ends, at the moments at which they are smallest.
        straight: Those of the straight line, likewise.
        left_out: Those of the path learned from the other recordings, likewise.
    """

    timing: Timing
    errors: PathErrors
    straight: PathErrors
    left_out: PathErrors


@dataclass(frozen=True, eq=False, repr=False)
class Learned(Morph):
    """A path learned from recorded movements: a `Morph` that knows how well it follows.

    Attributes:
        errors: Those of the path on the recording; of several, one after the other.
        straight: Those of the straight line at an even pace. Where the path is apart from its
            timing, each recorded frame picks its own moment, of both.
        timing: When the recording, the first of several, is where on the path; even where the path
            has the timing in it.
        repetitions: The recordings, where there are several.
        knots: How many its curves were given.
        knots_are_the_limit: Whether more knots would help more than more bends.
    """

    errors: PathErrors = _NO_ERRORS
    straight: PathErrors = _NO_ERRORS
    timing: Timing = linear
    repetitions: tuple[Repetition, ...] = ()
    knots: int = 0
    knots_are_the_limit: bool = False

    @property
    def gain(self) -> float:
        """How many times smaller the largest error is than on the straight line."""
        return _ratio(self.straight.lme, self.errors.lme)

    @property
    def carried(self) -> float | None:
        """How many times smaller the mean LME of recordings left out is; None of a single one."""
        if not self.repetitions:
            return None
        straight = np.mean([one.straight.lme for one in self.repetitions])
        return _ratio(
            float(straight), float(np.mean([one.left_out.lme for one in self.repetitions]))
        )

    @property
    def conclusion(self) -> str:
        """Whether the path carries over to another repetition, in a sentence."""
        if self.carried is None:
            return (
                "Learned from one recording: whether it carries over to another repetition, only "
                "another one can tell."
            )
        worse = sum(one.left_out.lme > one.straight.lme for one in self.repetitions)
        count = len(self.repetitions)
        found = (
            f"learned without it, the path divides the largest error of a recording by "
            f"{self.carried:.2f}, and is worse than the straight line on {worse} of {count}"
        )
        if self.carried >= _CARRIES and 2 * worse < count:
            return f"It carries over: {found}."
        return f"It does not carry over: {found}; use it for these recordings only."

    def to_dict(self) -> dict[str, Any]:
        """What was found, ready for JSON; errors are fractions of D."""
        return {
            "method": self.method,
            "bends": len(self.bends),
            "knots": self.knots,
            "knots_are_the_limit": self.knots_are_the_limit,
            "timing": self.timing.name,
            "errors": _facts(self.errors),
            "linear": _facts(self.straight),
            "carried": self.carried,
            "conclusion": self.conclusion,
            "repetitions": [
                {
                    "timing": one.timing.name,
                    "errors": _facts(one.errors),
                    "linear": _facts(one.straight),
                    "left_out": _facts(one.left_out),
                }
                for one in self.repetitions
            ],
        }

    def __repr__(self) -> str:
        return (
            f"Learned({len(self.neutral.vertices):,} vertices, {len(self.bends)} bends: LME "
            f"{self.errors.lme:.3%} of D, linear {self.straight.lme:.3%})"
        )


def bent(bare: Learned, fit: PathFit, splines: Splines, part: float = 1.0) -> Learned:
    """A straight path with a part of the bends of a fit, Δ with its curve the last.

    Each bend is as large as it moves vertices, so that no weight is above 1.
    """
    fields: list[NDArray[np.float64]] = []
    laws: list[BendCurve] = []
    first = int(fit.paced)
    for weights, shape in zip(fit.weights.T[first:], fit.shapes[first:], strict=True):
        peak = splines.curve(weights).peak[1]
        if peak and part and shape.any():
            fields.append(shape.T * (part * peak * bare.neutral.diameter))
            laws.append(splines.curve(weights / peak))
    if fit.paced and part and fit.weights[:, 0].any():
        fields.append(bare.delta)
        laws.append(splines.curve(part * fit.weights[:, 0]))
    stacked = np.array(fields).reshape(-1, *bare.delta.shape)
    return replace(bare, bends=stacked, bend_curves=tuple(laws))


def never_worse(
    bare: Learned,
    fit: PathFit,
    splines: Splines,
    measured: Callable[[Learned], tuple[float, Found]],
) -> tuple[Learned, float, Found]:
    """The path with as much of its bends as leaves no error larger than the straight line's.

    `measured` says how large the errors of a path are beside those, and whatever else it found.
    """
    for part in _PARTS:
        path = bent(bare, fit, splines, part)
        worst, found = measured(path)
        if worst <= 1.0:
            break
    return path, worst, found


def _ratio(before: float, after: float) -> float:
    return before / after if after else float("inf")


def _facts(errors: PathErrors) -> dict[str, float]:
    return {
        "lme": errors.lme,
        "lae": errors.lae,
        "mean_lme": errors.mean_lme,
        "mean_lae": errors.mean_lae,
    }
