"""How it will move: targets that turn, and a material on the curves of the face."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import extract_curves
from elastomorph.doctor.findings import Finding, finding, percent
from elastomorph.doctor.neutral import Neutral
from elastomorph.doctor.settings import BeamSettings
from elastomorph.errors import (
    ElastomorphError,
    ElastomorphWarning,
    ResonanceError,
    TimeLawWarning,
)
from elastomorph.model.mesh import Mesh
from elastomorph.paths.arc import local_rotations
from elastomorph.paths.rotation import rotation_path
from elastomorph.paths.rotations import ArcBend
from elastomorph.physics import BeamModes, Load

# The middle of an arc is off its chord by at most this part of the chord, for turns up to 90°.
_SAGITTA = np.tan(np.pi / 8) / 2
_RINGS = 2
_TIMES = np.linspace(0.0, 1.0, 17)
_IN_BETWEENS = (0.25, 0.375, 0.5, 0.625, 0.75)


def in_between_pays(neutral: Neutral, target: Mesh, file: str) -> list[Finding]:
    """Whether an in-between would pay, where, and how much.

    Targets are screened first: motions too short to bend so far, then arcs vertex by vertex, a
    larger guess of how far the whole surface bends.
    """
    if not len(target.faces):
        return []
    chords, limit = neutral.moved(target), neutral.limits.bend * neutral.scale
    if _SAGITTA * float(np.linalg.norm(chords, axis=1).max()) <= limit:
        return []
    mesh = neutral.mesh
    with warnings.catch_warnings():
        # Vertices on no polygon have a finding of their own.
        warnings.simplefilter("ignore", ElastomorphWarning)
        rotations = local_rotations(mesh, target, neutral.around, _RINGS)
        arcs = ArcBend.of(chords, rotations.vectors).at(0.5)
        if float(np.linalg.norm(arcs, axis=1).max()) <= limit:
            return []
        try:
            path = rotation_path(mesh, target, around=neutral.around, surface=neutral.surface)
        except ElastomorphError:  # no polygon has an area: a finding of its own
            return []
    off = np.linalg.norm(path(0.5) - (mesh.vertices + 0.5 * chords), axis=1)
    most, vertex = float(off.max()), int(off.argmax())
    if most <= limit:
        return []
    bending = off > 0.1 * limit
    time, left = _best_in_between(path, mesh.vertices[bending], chords[bending], bending)
    message = (
        f"at t = 0.5 the straight path is off the turning one by {percent(most / neutral.scale)} "
        f"of D (vertex {vertex}); an in-between at t = {time:g} leaves "
        f"{percent(left / neutral.scale)}"
    )
    return [finding("in-between-pays", file, message, vertices=(vertex,))]


def _best_in_between(
    path: Callable[[float], NDArray[np.float64]],
    start: NDArray[np.float64],
    chords: NDArray[np.float64],
    bending: NDArray[np.bool_],
) -> tuple[float, float]:
    """The time of the in-between that leaves least, and the distance it leaves at any time."""
    bends = np.stack([path(float(t))[bending] - start - t * chords for t in _TIMES])
    left = {}
    for time in _IN_BETWEENS:
        peak = bends[int(np.searchsorted(_TIMES, time))]
        share = np.minimum(_TIMES / time, (1.0 - _TIMES) / (1.0 - time))
        off = np.linalg.norm(bends - share[:, None, None] * peak, axis=2)
        left[time] = float(off.max())
    best = min(left, key=lambda time: (left[time], abs(time - 0.5)))
    return best, left[best]


def examine_material(neutral: Mesh, file: str, beam: BeamSettings) -> list[Finding]:
    """Try the material on every mode of every curve of the neutral."""
    network = extract_curves(neutral)
    curves = [(np.asarray(curve.vertices), curve.closed) for curve in network.curves]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", TimeLawWarning)
        try:
            BeamModes.prepare(curves, beam.material, Load.power(beam.order), closure=beam.closure)
        except ResonanceError as error:
            return [finding("resonant-material", file, str(error))]
    laws = (str(w.message) for w in caught if issubclass(w.category, TimeLawWarning))
    return [finding("overshooting-material", file, message) for message in dict.fromkeys(laws)]
