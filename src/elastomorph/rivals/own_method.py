"""A method of a rig at the table of its rivals: measured as they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence
from elastomorph.paths import Method, interpolate
from elastomorph.rivals.rival import Faces, Rival, require_surface


@dataclass(frozen=True)
class OwnMethod(Rival):
    """Any method of `elastomorph.interpolate`, for its cost."""

    name = "method"
    source = "elastomorph"

    method: Method

    @property
    def label(self) -> str:
        """That of the method."""
        return self.method.label

    def require(self, mesh: Mesh) -> None:
        """As for every rival."""
        if self.method.on_surfaces:
            require_surface(mesh)

    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time."""
        morph = interpolate(recording.mesh, recording.target, self.method, curves=curves)
        for time in times:
            yield morph.at(float(time))
