"""How far each closure of the mean tears a face along its curves."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass

from elastomorph.curves import CurveNetwork
from elastomorph.errors import TimeLawWarning
from elastomorph.evaluation.shape import Shape, ShapeProbe
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths import interpolate
from elastomorph.physics import CLOSURES, Material

__all__ = ["ClosureSeam", "closure_seams"]


@dataclass(frozen=True, eq=False)
class ClosureSeam:
    """One in-between under one closure.

    Attributes:
        closure: Its name.
        morph: The path.
        shape: Seam, flips and stretch of the in-between.
    """

    closure: str
    morph: Morph
    shape: Shape


def closure_seams(
    neutral: Mesh,
    target: Mesh,
    curves: CurveNetwork,
    *,
    closures: Sequence[str] = CLOSURES,
    time: float = 0.5,
    order: int = 2,
    material: Material | None = None,
) -> list[ClosureSeam]:
    """Solve one in-between under several closures and measure its seams.

    That a closure's law runs backwards is no news here, so no warning is given of it.

    Args:
        neutral: The mesh at t = 0.
        target: The mesh at t = 1.
        curves: The curves of the neutral.
        closures: Names of closures.
        time: t of the in-between.
        order: R of the load t^R.
        material: m, c, k; 1, 1, 1 by default.

    Raises:
        ParameterError: A closure that does not exist.
        TopologyError: Neutral and target differ in vertices or polygons.
    """
    probe = ShapeProbe.of(neutral, target, curves.curve_of)
    found = []
    for closure in closures:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", TimeLawWarning)
            morph = interpolate(
                neutral,
                target,
                "beam",
                order=order,
                closure=closure,
                material=material,
                curves=curves,
            )
        found.append(ClosureSeam(closure, morph, probe.at(morph, time, morph.at(time))))
    return found
