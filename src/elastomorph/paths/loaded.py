"""What methods share that move by a load p(t): ease, beams and plates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import elastomorph.paths.options as options
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.method import Method, Prepared
from elastomorph.physics import Load

# A bend below this part of the displacement is rounding noise of transforms and solves.
_NOISE = 1e-13


@dataclass(frozen=True)
class Loaded(Method):
    """A method that moves by a load p(t): t^R, or any polynomial.

    Attributes:
        order: R of the load t^R, from 1 to 20.
        load: Any polynomial load instead of t^R.
    """

    order: int = options.order()
    load: Load | None = options.load()

    @property
    def external_load(self) -> Load:
        """p(t): the load given, or t^R."""
        return Load.power(self.order) if self.load is None else self.load

    @property
    def limit_bend(self) -> BendCurve:
        """The bend curve p(t)/p(1) - t of Δ."""
        coefficients = np.concatenate([[0.0], self.external_load.limit_law])
        coefficients[1] -= 1.0
        return BendCurve.polynomial(coefficients)

    @property
    def label(self) -> str:
        """As `Method.label`, with the load always."""
        load = f"R={self.order}"
        if self.load is not None:
            load = f"load {','.join(f'{p:g}' for p in self.load.coefficients)}"
        return " ".join([self.name, load, *self._differences])

    def modal_path(
        self, neutral: Mesh, bends_of: Callable[[NDArray[np.float64]], NDArray[np.float64]]
    ) -> Prepared:
        """A function from target to path, with (K, V, 3) bends of t², t³, … from (V, 3) Δ."""
        limit, label = self.limit_bend, self.label

        def to(target: Mesh) -> Morph:
            delta = target.vertices - neutral.vertices
            bends = bends_of(delta)
            noise = _NOISE * float(np.abs(delta).max(initial=0.0))
            kept = [power for power, bend in enumerate(bends) if np.abs(bend).max() > noise]
            if len(kept) < len(bends):
                bends = bends[kept]
            powers = tuple(BendCurve.power(power + 2) for power in kept)
            return Morph(neutral, target, bends, powers, method=label, limit_law=limit)

        return to
