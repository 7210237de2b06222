"""One row of what holds a rig together: what was added, why, and what it does."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.model.morph import Morph
from elastomorph.rig import Rig


@dataclass(frozen=True)
class Correction:
    """A corrective that was added, or what was left as it is and why.

    Attributes:
        name: Of the corrective; where none was added, of the slider or pair concerned.
        drivers: Sliders that drive it.
        law: How, as for `elastomorph.Corrective`; empty where none was added.
        numbers: Of the law.
        before: Damage without it: how far lids slide past each other at most, or how much deeper
            lips pass than by single sliders, in the unit of the rig; of folds, how many triangles
            are seen folded, a frame.
        after: What is left of it.
        diameter: D of the rig; 0 where damage is a number of folds.
        frames: Frames of the takes in which its weight is above 0; 0 without takes.
        targets: Morph targets it costs.
        note: What was left out or kept, in a sentence; empty where there is nothing to say.
    """

    name: str
    drivers: tuple[str, ...] = ()
    law: str = ""
    numbers: tuple[float, ...] = ()
    before: float = 0.0
    after: float = 0.0
    diameter: float = 0.0
    frames: int = 0
    targets: int = 0
    note: str = ""

    @property
    def fractions(self) -> tuple[float, float]:
        """Damage before and after, as fractions of D; 0 of folds."""
        scale = self.diameter or np.inf
        return self.before / scale, self.after / scale


def straight_morph(rig: Rig, vertices: NDArray[np.int64], shift: NDArray[np.float64]) -> Morph:
    """The straight morph of a corrective: (N, 3) what a weight of 1 adds to (N,) vertices."""
    target = rig.neutral.vertices.copy()
    target[vertices] += shift
    none = np.zeros((0, *target.shape))
    return Morph(rig.neutral, rig.neutral.with_vertices(target), none, ())
