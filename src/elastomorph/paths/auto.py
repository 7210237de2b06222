"""The straight line where turning would hardly differ from it, else least distortion.

A rig owns the path and a performance owns the timing, so either path has even timing. Most targets
of a face hardly turn anything, and a straight line costs nothing to store or play.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

import elastomorph.paths.options as options
from elastomorph.curves import CurveNetwork
from elastomorph.errors import MeshError
from elastomorph.model.mesh import Mesh
from elastomorph.model.morph import Choice, Morph
from elastomorph.numbers import as_number
from elastomorph.paths.arc import Arcs, neighbourhoods
from elastomorph.paths.method import Method, Prepared
from elastomorph.paths.rotation import Turning
from elastomorph.paths.rotations import SurfaceEdges
from elastomorph.paths.rotations.passing import Sheets
from elastomorph.paths.straight import Linear

INBETWEEN_PAYS = 2.5e-3
"""Where the straight and the turning path part by more halfway, as a fraction of D, only a scanned
or sculpted in-between can say which of them is right."""

# Triangles that span so few points in one sheet, as those of Delaunay do between markers, are no
# skin: an edge across a cheek turns by what its two ends do, which is no turn of the cheek. Sheets
# of still fewer points are no faces.
_MARKERS = range(24, 100)


@dataclass(frozen=True)
class Auto(Method):
    """The straight line where the path of ``rotation`` stays close to it, else that path.

    Attributes:
        tolerance: How closely the bends hold the path, as a fraction of D; smaller ones cost more
            bends.
        straight_within: How far from the straight line the path of ``rotation`` may be, halfway
            and as a fraction of D, and is still replaced by it.
    """

    name = "auto"
    path = "the straight line where rotation hardly differs from it, else rotation"
    turns = True

    tolerance: float = options.tolerance()
    straight_within: float = options.number(
        5e-4,
        "how close to straight a turn goes straight, as a fraction of D",
        "1e-3",
        least=0,
        label=lambda within: f"{within:g}",
        word=options.Word(
            options.as_float,
            "distance",
            "number; auto takes the distance within which it goes straight, as a fraction of D, "
            "as in auto:0.001",
        ),
    )

    def prepare(
        self, neutral: Mesh, curves: CurveNetwork | None = None, *, extent: float | None = None
    ) -> Prepared:
        """A function from target to path, which says what it chose and why in `Morph.choice`.

        The path of ``rotation`` is compared with the straight line halfway: by a bound where that
        is enough, else by the one solve that the moment takes. A neutral without a surface, of
        markers, has no such path: those of its curves that turn, such as a chin, follow ``arc``.
        Nor has a sheet of triangles between two dozen to a hundred points: it stands for markers.

        Args:
            neutral: The mesh at t = 0.
            curves: What joins the vertices of a neutral without polygons.
            extent: D, which ``straight_within`` is a fraction of; ``neutral.diameter`` by default.

        Raises:
            BakeError: A turn is too sharp to be stored.
        """
        if extent is not None:
            extent = as_number(extent, "extent", least=0)
        scale = (neutral.diameter if extent is None else extent) or 1.0
        straight = Linear().prepare(neutral)
        around = neighbourhoods(neutral, curves)
        surface = _surface(neutral)
        sheets = cache(partial(Sheets.of, neutral, around))
        within = self.straight_within

        def to(target: Mesh) -> Morph:
            found: Arcs | Turning
            if surface is None:
                found = Arcs.of(neutral, target, around, only_turns=True)
                choice = Choice(_longest(found.at(0.5)) / scale, within)
            else:
                found = Turning.of(neutral, target, around, surface)
                choice = _choice(found, within, scale)
                if not choice.straight and (hidden := found.hidden(within * scale)).any():
                    found = found.without(hidden)
                    choice = replace(_choice(found, within, scale), hidden=int(hidden.sum()))
            shrunk = int(found.rotations.straight.sum()) - choice.hidden
            choice = replace(choice, shrunk=shrunk)
            if choice.straight:
                return replace(straight(target), choice=choice)
            if isinstance(found, Arcs):
                path = replace(found.stored(self.tolerance, "arc"), choice=choice)
            else:
                path = found.stored(self.tolerance, "rotation", sheets(), scale, choice)
            middle = (neutral.vertices + target.vertices) / 2.0
            left = _longest(path.at(0.5) - middle) / scale
            if left < choice.distance - path.bake_error * neutral.diameter / scale:
                # Closer than rounding to bends explains: eased where the face would fold or pass.
                choice = replace(path.choice or choice, distance=left)
                path = replace(path, choice=choice)
            if choice.straight:
                return replace(straight(target), choice=replace(choice, crossing=0, deeper=0.0))
            return path

        return to


def _choice(turning: Turning, allowed: float, scale: float) -> Choice:
    bound = turning.equation.at_most(0.5) / scale
    if bound <= allowed:
        return Choice(bound, allowed, exact=bound == 0.0)
    return Choice(_longest(turning.equation.at(0.5)) / scale, allowed)


def _surface(neutral: Mesh) -> SurfaceEdges | None:
    faces = neutral.faces
    disc = len(neutral.vertices) - len(neutral.edges) + len(faces) == 1
    if len(neutral.vertices) in _MARKERS and disc and (faces.sizes == 3).all():
        return None  # a triangulation of markers
    try:
        return SurfaceEdges.of(neutral)
    except MeshError:  # no polygon has an area
        return None


def _longest(offsets: NDArray[np.float64]) -> float:
    return float(np.linalg.norm(offsets, axis=1).max(initial=0.0))
