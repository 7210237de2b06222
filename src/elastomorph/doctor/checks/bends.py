"""Targets that turn: how far the straight path is from the turning one, and what mends it."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.words import percent
from elastomorph.errors import ElastomorphError, ElastomorphWarning
from elastomorph.model.mesh import Mesh
from elastomorph.paths.arc import local_rotations, neighbourhoods
from elastomorph.paths.rotation import rotation_path
from elastomorph.paths.rotations import ArcBend, Neighbourhoods, SurfaceEdges

__all__ = ["BendCheck"]

# The middle of an arc is off its chord by at most this part of the chord, for turns up to 90°.
_SAGITTA = np.tan(np.pi / 8) / 2
# Arcs of single vertices are a first, larger guess of how far the whole surface bends.
_GUESS = 1.0
_RINGS = 2
_TIMES = np.linspace(0.0, 1.0, 17)
_IN_BETWEENS = (0.25, 0.375, 0.5, 0.625, 0.75)


class BendCheck:
    """Compares straight paths with those that turn with the surface."""

    def __init__(self, neutral: Mesh, bend: float) -> None:
        """Prepare for the targets of a neutral.

        Args:
            neutral: The neutral.
            bend: Distance of the two paths at t = 0.5 worth an in-between, as a fraction of D.
        """
        self._neutral, self._bend = neutral, bend
        self._scale = neutral.diameter or 1.0

    @cached_property
    def _around(self) -> Neighbourhoods:
        return neighbourhoods(self._neutral)

    @cached_property
    def _surface(self) -> SurfaceEdges:
        return SurfaceEdges.of(self._neutral)

    def target(self, mesh: Mesh, file: str) -> list[Finding]:
        """Whether an in-between would pay, where, and how much.

        Targets are screened first: motions too short to bend so far, then arcs vertex by vertex.
        """
        if not len(mesh.faces):
            return []
        chords = mesh.vertices - self._neutral.vertices
        limit = self._bend * self._scale
        if _SAGITTA * float(np.linalg.norm(chords, axis=1).max()) <= limit:
            return []
        with warnings.catch_warnings():
            # Vertices on no polygon have a finding of their own.
            warnings.simplefilter("ignore", ElastomorphWarning)
            rotations = local_rotations(self._neutral, mesh, self._around, _RINGS)
            arcs = ArcBend.of(chords, rotations.vectors).at(0.5)
            if float(np.linalg.norm(arcs, axis=1).max()) <= _GUESS * limit:
                return []
            try:
                path = rotation_path(
                    self._neutral, mesh, around=self._around, surface=self._surface
                )
            except ElastomorphError:  # no polygon has an area: a finding of its own
                return []
        off = np.linalg.norm(path(0.5) - (self._neutral.vertices + 0.5 * chords), axis=1)
        most, vertex = float(off.max()), int(off.argmax())
        if most <= limit:
            return []
        time, left = self._best(path, chords, off > 0.1 * limit)
        message = (
            f"at t = 0.5 the straight path is off the turning one by {percent(most / self._scale)} "
            f"of D (vertex {vertex}); an in-between at t = {time:g} leaves "
            f"{percent(left / self._scale)}"
        )
        return [finding("in-between-pays", file, message, vertices=(vertex,))]

    def _best(
        self,
        path: Callable[[float], NDArray[np.float64]],
        chords: NDArray[np.float64],
        bending: NDArray[np.bool_],
    ) -> tuple[float, float]:
        """The time of the in-between that leaves least, and the distance it leaves at any time."""
        start = self._neutral.vertices[bending]
        bends = np.stack([path(float(t))[bending] - start - t * chords[bending] for t in _TIMES])
        left = {}
        for time in _IN_BETWEENS:
            peak = bends[int(np.searchsorted(_TIMES, time))]
            share = np.minimum(_TIMES / time, (1.0 - _TIMES) / (1.0 - time))
            off = np.linalg.norm(bends - share[:, None, None] * peak, axis=2)
            left[time] = float(off.max())
        best = min(left, key=lambda time: (left[time], abs(time - 0.5)))
        return best, left[best]
