"""``vertex-cubic``: a cubic in time for every vertex, fitted to all frames of the recording.

After Liu, Xia, Fan and Wang, *Exploring Non-Linear Relationship of Blendshape Facial Animation*
(Computer Graphics Forum 30, 2011), the paper's [1]: where a face is, is a cubic polynomial of its
weight, whose coefficients are found from some 500 captured expressions. Here one weight runs from 0
to 1, and

    x(t) = x₀ + t Δ + (t² - t) q + (t³ - t) r        min over q, r of Σ_i ‖x(t_i) - x̄_i‖²

for each vertex alone. It knows the answer: no other cubic through both ends is closer to the
recording in the mean square, so it is the bound of a table, not a competitor.

Ours, where the source leaves it open: both ends are held, as every other row holds them; with fewer
than two frames between them, of all cubics that fit, the one of smallest q and r.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.model.sequence import MeshSequence
from elastomorph.rivals.rival import Faces, Rival, straight


@dataclass(frozen=True)
class VertexCubic(Rival):
    """A cubic in time for every vertex, fitted to all frames."""

    name = "vertex-cubic"
    source = "Liu and others 2011, [1]"
    informed = True

    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time."""
        inner = range(1, len(recording) - 1)
        off = [recording.frames[i] - straight(recording, float(recording.times[i])) for i in inner]
        wanted = np.reshape(off, (len(off), recording.mesh.vertices.size))
        fitted = np.linalg.lstsq(_powers(recording.times[1:-1]), wanted, rcond=None)[0]
        for time in times:
            bent = _powers(np.array([time])) @ fitted
            yield straight(recording, float(time)) + bent.reshape(-1, 3)


def _powers(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 2) what bends a straight line into a cubic with the same ends."""
    return np.stack([times**2 - times, times**3 - times], axis=1)
