"""Rigs under weights that run together: what the viewer's master t does, for pictures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.paths import Method
from elastomorph.rig import Rig
from elastomorph.rig.remade import with_paths as remade
from elastomorph.rig.timing import Timing

__all__ = ["PosedRig", "swing", "with_paths"]


@dataclass(frozen=True, eq=False)
class PosedRig:
    """A rig and the weights it runs to.

    Attributes:
        label: What it is called beside its row of a strip.
        rig: The rig.
        weights: Weight of each slider at t = 1; those left out stay 0.
    """

    label: str
    rig: Rig
    weights: Mapping[str, float]

    def at(self, t: float) -> NDArray[np.float64]:
        """Positions at one master time: each path at its weight times t.

        Raises:
            ParameterError: The rig has no such slider, or a number is not finite.
        """
        if not np.isfinite(t):
            raise ParameterError(f"t must be a finite number, found {t}")
        return self.rig.pose({name: weight * t for name, weight in self.weights.items()})


def with_paths(rig: Rig, method: Method | None, sliders: Mapping[str, float]) -> Rig:
    """The rig with the paths of a method to the same targets, for some of its sliders.

    Morphs that these sliders do not move keep theirs, for paths may cost time to find.

    Args:
        rig: The rig.
        method: How the paths are made; None for the default where there are none yet.
        sliders: What will be moved, by name.

    Raises:
        ParameterError: An unknown name.
    """
    rig.sliders.row(sliders)
    correctives = rig.sliders.correctives
    moved = [
        name
        for name in rig.morphs
        if all(driver in sliders for driver in correctives.get(name, (name,)))
    ]
    return remade(rig, method, names=moved)


def swing(count: int, timing: Timing, reach: float = 1.0) -> NDArray[np.float64]:
    """t of each frame of a clip that goes from 0 to its end and back, to be played in a loop.

    A timing that comes back by itself, as a blink does, is played once instead.

    Args:
        count: Number of frames.
        timing: How t runs on the way there; the way back is its mirror image.
        reach: The value of t at the end.

    Returns:
        (count,) numbers. The last frame is one step before the first.
    """
    clip = np.arange(count) / count
    start, end = timing.at([0.0, 1.0])
    there = clip if end == start else 1.0 - np.abs(1.0 - 2.0 * clip)
    return np.asarray(reach * timing.at(there))
