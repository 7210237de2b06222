"""What a fit found, how well it holds, and how to use it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from elastomorph.evaluation.summary import same
from elastomorph.paths import Method
from elastomorph.physics import Load, Material


@dataclass(frozen=True)
class Ratio:
    """c/k or m/k with its 95 % interval.

    Attributes:
        value: Where the fit is best; None if the motions do not identify it.
        low: 0 where nothing bounds it from below.
        high: Infinity where nothing bounds it from above.
        refits: Its lowest and highest value when one motion after the other is left out.
    """

    SHOWN: ClassVar = ("value", "low", "high", "identified", "reproducible", "refits")

    value: float | None
    low: float
    high: float
    refits: tuple[float, float] | None = None

    @property
    def identified(self) -> bool:
        """Whether it is bounded on both sides."""
        return self.low > 0 and math.isfinite(self.high)

    @property
    def reproducible(self) -> bool:
        """Whether it is identified and stays in its interval whichever motion is left out."""
        if not self.identified or self.refits is None:
            return False
        return self.low <= self.refits[0] and self.refits[1] <= self.high


@dataclass(frozen=True)
class Errors:
    """How far one method is from the motions, over the frames between first and last.

    Attributes:
        label: ``linear``, ``ease`` or ``beam``.
        rms: Root of the mean squared distance over the curves' vertices, frames and motions, as a
            fraction of D.
        lme: Largest maximum error over curves and times, mean over the motions.
        lae: Largest average error over curves and times, mean over the motions.
    """

    label: str
    rms: float
    lme: float
    lae: float


@dataclass(frozen=True, eq=False)
class CurveFit:
    """The fit of one curve alone, with the degree of the common fit.

    Attributes:
        name: Name of the curve, or its number.
        load: p(t) with p(1) = 1; None for a curve that does not move.
        damping: c/k.
        mass: m/k.
        rms: RMS of the beam over D.
        linear_rms: RMS of linear interpolation over D.
        left_out_rms: RMS on motions left out of the fit; NaN if there is only one.
    """

    name: str
    load: Load | None
    damping: Ratio
    mass: Ratio
    rms: float
    linear_rms: float
    left_out_rms: float


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """Material and load that captured motions have in common.

    Attributes:
        material: (m/k, c/k, 1); None if neither ratio is identified: the curves are so stiff that
            all of them follow the load, whatever they are made of.
        load: p(t) with p(1) = 1.
        degree: R, the degree of p.
        closure: Time law of the means.
        damping: c/k with its interval, from the profile of the squared distance.
        mass: m/k, likewise.
        load_intervals: 95 % intervals of p₁ … p_R, from the Jacobian at the optimum.
        degree_errors: RMS over D by degree, on motions left out (of all motions, if there is only
            one).
        chosen: How the degree was chosen: ``given``, ``leave-one-out`` or ``BIC``.
        excursion: How far the worst law leaves [0, 1] or runs back; the fit allows 0.1.
        in_sample: Errors of linear, ease and beam on the motions fitted.
        left_out: The same on each motion, fitted without it; empty if there is only one.
        left_out_rms: (motions, 3) RMS of each motion and method, over D.
        per_curve: Every curve fitted alone, if that was asked for.
        motions: Number of motions.
        frames: Number of frames between first and last ones.
        curves: Number of curves.
        vertices: Number of vertices of the curves.
        diameter: D of the first motion, in the unit of the vertices.
    """

    material: Material | None
    load: Load
    degree: int
    closure: str
    damping: Ratio
    mass: Ratio
    load_intervals: tuple[tuple[float, float], ...]
    degree_errors: dict[int, float]
    chosen: str
    excursion: float
    in_sample: tuple[Errors, ...]
    left_out: tuple[Errors, ...]
    left_out_rms: NDArray[np.float64]
    per_curve: tuple[CurveFit, ...]
    motions: int
    frames: int
    curves: int
    vertices: int
    diameter: float

    @property
    def method(self) -> Method:
        """The method to interpolate with: a beam, or `ease` where no material is identified."""
        if self.material is None:
            return Method("ease", load=self.load)
        return Method("beam", material=self.material, load=self.load, closure=self.closure)

    @property
    def beats_linear(self) -> bool | None:
        """Whether motions left out are closer to the fit than to linear; None if unknown.

        By 1 % or more in the RMS over all of them, and more than half of them one by one.
        """
        return self._beats(0)

    @property
    def beats_ease(self) -> bool | None:
        """The same of `ease` with a load fitted alike instead of linear."""
        return self._beats(1)

    def _beats(self, other: int) -> bool | None:
        if not self.left_out:
            return None
        theirs, ours = self.left_out[other].rms, self.left_out[2].rms
        closer = self.left_out_rms[:, 2] < self.left_out_rms[:, other]
        return ours < theirs and not same(ours, theirs) and 2 * int(closer.sum()) > self.motions

    def text(self, width: int = 100) -> str:
        """The fit for people: constants, a table of errors, and what they amount to."""
        from elastomorph.fitting.text import fit_text

        return fit_text(self, width)

    def to_dict(self) -> dict[str, Any]:
        """Everything found, ready for JSON; what is infinite or unknown is null."""
        from elastomorph.fitting.text import fit_facts

        return fit_facts(self)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"Fit({self.method.label}, {self.motions} motions)"
