"""What was learned from a recording: a path, and how well it follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.evaluation.curve_errors import CurveErrors, CurveVertices, curve_errors
from elastomorph.model.morph import Morph
from elastomorph.model.sequence import MeshSequence

__all__ = ["Learned", "PathErrors"]

_NONE = np.zeros((0, 0))


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
        average, maximum = np.empty((2, len(take)))
        for i, moment in enumerate(moments):
            own = None if counted is None else counted[i]
            errors = curve_errors(
                path.at(float(moment)), take.frames[i], along, take.mesh.diameter, own
            )
            average[i], maximum[i] = (error.max() for error in errors)
        return cls(average, maximum)

    def never_above(self, others: PathErrors) -> bool:
        """Whether neither the largest error nor the largest mean is larger than another's."""
        return self.lme <= others.lme and self.lae <= others.lae


_NO_ERRORS = PathErrors(_NONE, _NONE)


@dataclass(frozen=True, eq=False, repr=False)
class Learned(Morph):
    """A path learned from a recorded movement: a `Morph` that knows how well it follows.

    Attributes:
        errors: Those of the path on the recording.
        straight: Those of the straight line at an even pace.
    """

    errors: PathErrors = _NO_ERRORS
    straight: PathErrors = _NO_ERRORS

    @property
    def gain(self) -> float:
        """How many times smaller the largest error is than on the straight line."""
        return self.straight.lme / self.errors.lme if self.errors.lme else float("inf")

    def to_dict(self) -> dict[str, Any]:
        """What was found, ready for JSON; errors are fractions of D."""
        return {
            "method": self.method,
            "bends": len(self.bends),
            "errors": _facts(self.errors),
            "linear": _facts(self.straight),
        }

    def __repr__(self) -> str:
        return (
            f"Learned({len(self.neutral.vertices):,} vertices, {len(self.bends)} bends: LME "
            f"{self.errors.lme:.3%} of D, linear {self.straight.lme:.3%})"
        )


def _facts(errors: PathErrors) -> dict[str, float]:
    return {
        "lme": errors.lme,
        "lae": errors.lae,
        "mean_lme": errors.mean_lme,
        "mean_lae": errors.mean_lae,
    }
