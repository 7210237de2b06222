"""Elastic beams: every curve obeys the equation of motion, solved in closed form (Eqs. 31-33)."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.paths.ease import law_bend
from elastomorph.paths.method import Method
from elastomorph.physics import BeamModes

__all__ = ["prepare"]

# A bend below this part of the displacement is rounding noise of the transforms.
_NOISE = 1e-13


def prepare(
    neutral: Mesh, method: Method, curves: CurveNetwork | None = None
) -> Callable[[Mesh], Morph]:
    """A function from target to path; one bend for each power t², …, t^R (t^(R+1) for some means).

    Args:
        neutral: The mesh at t = 0.
        method: Load, material, closure and options of the beams.
        curves: The curves of the neutral; found by `extract_curves` by default. Vertices on no
            curve follow the limit law.

    Raises:
        CurveError: The curves belong to a mesh with another number of vertices.
        ResonanceError: The material is singular for this load.
    """
    if curves is None:
        curves = extract_curves(neutral)
    require_curves_of(curves, len(neutral.vertices), neutral.name)
    load = method.external_load
    modes = BeamModes.prepare(
        [(curve.vertices, curve.closed) for curve in curves],
        method.material,
        load,
        closure=method.closure,
        basis=method.basis,
        harmonics=method.harmonics,
        lengths=_lengths(neutral, curves) if method.stiffness == "length" else None,
    )
    limit = law_bend(load)

    def to(target: Mesh) -> Morph:
        delta = target.vertices - neutral.vertices
        bends = modes.bends(delta)
        noise = _NOISE * float(np.abs(delta).max(initial=0.0))
        kept = [power for power, bend in enumerate(bends) if np.abs(bend).max() > noise]
        if len(kept) < len(bends):
            bends = bends[kept]
        powers = tuple(BendCurve.power(power + 2) for power in kept)
        return Morph(neutral, target, bends, powers, method=method.label, limit_law=limit)

    return to


def _lengths(neutral: Mesh, curves: CurveNetwork) -> NDArray[np.float64]:
    """(curves,) length of each curve on the neutral, over D."""
    lengths = np.empty(len(curves))
    for number, curve in enumerate(curves):
        points = neutral.vertices[curve.vertices]
        if curve.closed:
            points = np.concatenate([points, points[:1]])
        lengths[number] = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    return lengths / (neutral.diameter or 1.0)
