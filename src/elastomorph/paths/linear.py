"""Plain linear interpolation V₀ + tΔ (Eq. 34): what every rig does today."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.method import Method, Prepared

__all__ = ["Linear"]


@dataclass(frozen=True)
class Linear(Method):
    """The straight line at an even pace; no bends."""

    name = "linear"
    path = "straight line at an even pace (Eq. 34)"

    def prepare(self, neutral: Mesh, curves: CurveNetwork | None = None) -> Prepared:
        """A function from target to path."""
        none = np.zeros((0, *neutral.vertices.shape))
        return lambda target: Morph(neutral, target, none, (), method=self.label)
