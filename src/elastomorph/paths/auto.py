"""The straight line where turning would hardly differ from it, else least distortion.

A rig owns the path and a performance owns the timing, so either path has even timing. Most targets
of a face hardly turn anything, and a straight line costs nothing to store or play.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import MeshError
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Choice, Morph
from elastomorph.paths import linear
from elastomorph.paths.arc import Arcs, neighbourhoods
from elastomorph.paths.method import Method
from elastomorph.paths.rotation import Turning
from elastomorph.paths.rotations import SurfaceEdges

__all__ = ["INBETWEEN_PAYS", "prepare"]

INBETWEEN_PAYS = 2.5e-3
"""Where the straight and the turning path part by more halfway, as a fraction of D, only a scanned
or sculpted in-between can say which of them is right."""


def prepare(
    neutral: Mesh,
    method: Method,
    curves: CurveNetwork | None = None,
    *,
    extent: float | None = None,
) -> Callable[[Mesh], Morph]:
    """A function from target to path, which says what it chose and why in `Morph.choice`.

    The path of ``rotation`` is compared with the straight line halfway: by a bound where that is
    enough, else by the one solve that the moment takes. A neutral without a surface, of markers,
    has no such path: those of its curves that turn, such as a chin, follow ``arc``.

    Args:
        neutral: The mesh at t = 0.
        method: ``straight_within`` decides, ``tolerance`` is that of bends.
        curves: What joins the vertices of a neutral without polygons; they go straight otherwise.
        extent: D, which ``straight_within`` is a fraction of; ``neutral.diameter`` by default.

    Raises:
        BakeError: A turn is too sharp to be stored.
    """
    scale = (neutral.diameter if extent is None else extent) or 1.0
    straight = linear.prepare(neutral, Method("linear"))
    around = neighbourhoods(neutral, curves)
    surface = _surface(neutral)
    bent = Method("arc" if surface is None else "rotation", tolerance=method.tolerance)

    def to(target: Mesh) -> Morph:
        found: Arcs | Turning
        if surface is None:
            found = Arcs.of(neutral, target, around).where_edges_turn()
            choice = Choice(_longest(found.at(0.5)) / scale, method.straight_within)
        else:
            found = Turning.of(neutral, target, around, surface)
            choice = _choice(found, method.straight_within, scale)
        if choice.straight:
            return replace(straight(target), choice=choice)
        path = found.stored(bent)
        middle = (neutral.vertices + target.vertices) / 2.0
        left = _longest(path.at(0.5) - middle) / scale
        if left < choice.distance - path.bake_error * neutral.diameter / scale:
            # Closer than rounding to bends explains: they were eased where the face would fold.
            choice = Choice(left, method.straight_within)
        return replace(straight(target) if choice.straight else path, choice=choice)

    return to


def _choice(turning: Turning, allowed: float, scale: float) -> Choice:
    bound = turning.equation.at_most(0.5) / scale
    if bound <= allowed:
        return Choice(bound, allowed, exact=bound == 0.0)
    return Choice(_longest(turning.equation.at(0.5)) / scale, allowed)


def _surface(neutral: Mesh) -> SurfaceEdges | None:
    try:
        return SurfaceEdges.of(neutral)
    except MeshError:  # no polygon has an area
        return None


def _longest(offsets: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(offsets, axis=1).max(initial=0.0))
