"""Plain linear interpolation V₀ + tΔ (Eq. 34): what every rig does today."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.method import Method

__all__ = ["prepare"]


def prepare(
    neutral: Mesh, method: Method, curves: CurveNetwork | None = None
) -> Callable[[Mesh], Morph]:
    """A function from target to path; no bends."""
    none = np.zeros((0, *neutral.vertices.shape))
    return lambda target: Morph(neutral, target, none, (), method=method.label)
