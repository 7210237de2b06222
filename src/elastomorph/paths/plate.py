"""Elastic plates: the surface itself obeys the equation of motion, without curves."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Morph
from elastomorph.model.surface import surface_operators
from elastomorph.paths.ease import law_bend
from elastomorph.paths.method import Method
from elastomorph.physics.plate import PlateModes

__all__ = ["prepare"]

# A bend below this part of the displacement is rounding noise of the solves.
_NOISE = 1e-13


def prepare(
    neutral: Mesh,
    method: Method,
    curves: CurveNetwork | None = None,
    *,
    rigidity: ArrayLike | None = None,
    pinned: ArrayLike | None = None,
) -> Callable[[Mesh], Morph]:
    """A function from target to path; one bend for each power t², …, t^R (t^(R+1) for some means).

    The operators of the neutral are factored once. Lengths are in √area of the neutral, so m, c
    and k mean the same at any scale. Each connected piece (a tooth, an eye) has its own mean,
    which follows the closure.

    Args:
        neutral: The mesh at t = 0, with polygons.
        method: Load, material, closure and harmonics of the plate.
        curves: Not used; a plate needs none.
        rigidity: A factor of ``method.material.rigidity`` everywhere, or (V,) painted for each
            vertex; above 0, within a ratio of a million.
        pinned: Vertex indices, or (V,) bool: these follow the limit law p(t)/p(1) exactly, and so
            do vertices on no polygon. A piece with a pinned vertex has no mean of its own.

    Raises:
        MeshError: The neutral has no polygon with an area.
        ParameterError: A rigidity or a pinned vertex is out of range.
        ResonanceError: The material is singular for this load.
    """
    count = len(neutral.vertices)
    surface = surface_operators(neutral)
    load = method.external_load
    modes = PlateModes.prepare(
        surface.stiffness,
        surface.mass,
        surface.component_of,
        method.material,
        load,
        closure=method.closure,
        rigidity=_painted(rigidity, count),
        pinned=_pinned(pinned, count),
        harmonics=method.harmonics,
    )
    limit = law_bend(load)

    def to(target: Mesh) -> Morph:
        delta = target.vertices - neutral.vertices
        bends = modes.bends(delta)
        noise = _NOISE * float(np.abs(delta).max(initial=0.0))
        kept = [power for power, bend in enumerate(bends) if np.abs(bend).max() > noise]
        powers = tuple(BendCurve.power(power + 2) for power in kept)
        return Morph(neutral, target, bends[kept], powers, method=method.label, limit_law=limit)

    return to


def _painted(rigidity: ArrayLike | None, count: int) -> NDArray[np.float64] | None:
    if rigidity is None:
        return None
    try:
        factors = np.asarray(rigidity, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(f"rigidity must be numbers, found {rigidity!r}") from None
    return np.full(count, float(factors)) if factors.ndim == 0 else factors


def _pinned(pinned: ArrayLike | None, count: int) -> NDArray[np.bool_] | None:
    """(V,) which vertices are pinned, from indices or from a mask."""
    if pinned is None:
        return None
    chosen = np.asarray(pinned)
    if chosen.dtype == bool:
        if chosen.shape != (count,):
            raise ParameterError(
                f"pinned as a mask needs {count:,} values, one a vertex, found {chosen.shape}"
            )
        return chosen
    mask = np.zeros(count, dtype=bool)
    if chosen.size:
        if chosen.ndim != 1 or not np.issubdtype(chosen.dtype, np.integer):
            raise ParameterError(f"pinned must be a list of vertex indices, found {pinned!r}")
        if chosen.min() < 0 or chosen.max() >= count:
            raise ParameterError(
                f"pinned vertices must lie between 0 and {count - 1:,}, found {chosen.min()} to "
                f"{chosen.max()}"
            )
        mask[chosen] = True
    return mask
