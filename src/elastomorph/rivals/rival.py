"""What every rival is: told a recording or its ends, it gives faces, one after another."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, fields
from importlib.util import find_spec
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.curves import CurveNetwork, extract_curves, require_curves_of
from elastomorph.errors import MeshError, MissingExtraError, ParameterError
from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence, require_motion
from elastomorph.numbers import as_numbers

Faces = Iterator[NDArray[np.float64]]
"""(V, 3) float64 faces in the order of the times asked for; what prepares comes with the first."""


@dataclass(frozen=True)
class Rival(ABC):
    """A way to come from a neutral to a target, kept for comparison.

    It is no method of a rig: it may cost minutes a face, miss its own ends or know the answer.
    """

    name: ClassVar[str]
    source: ClassVar[str]  # Whose idea it is
    informed: ClassVar[bool] = False  # Whether it is told the frames between the ends
    on_surfaces: ClassVar[bool] = False  # Whether it needs polygons, which markers do not have
    package: ClassVar[str] = ""  # What it needs of the extra ``rivals``

    @property
    def label(self) -> str:
        """The name, and the options that are not the usual ones."""
        usual = type(self)()
        words = [self.name]
        for name in (each.name for each in fields(self)):
            value = getattr(self, name)
            if value != getattr(usual, name):
                words.append(value if isinstance(value, str) else f"{name}={value}")
        return " ".join(words)

    @property
    def limit_law(self) -> BendCurve:
        """The bend curve of Δ that all of a face follows where no seam opens: even by default."""
        return BendCurve.polynomial([0.0])

    def require(self, mesh: Mesh) -> None:
        """Raise what stands in the way of trying it on a mesh at all.

        Raises:
            MeshError: It needs a surface, and markers have none.
            MissingExtraError: It needs a package that is not installed.
        """
        if self.on_surfaces:
            require_surface(mesh)
        if self.package and find_spec(self.package) is None:
            raise MissingExtraError(self.package, "rivals")

    def poses(
        self, recording: MeshSequence, times: ArrayLike, curves: CurveNetwork | None = None
    ) -> NDArray[np.float64]:
        """The faces at some times.

        Args:
            recording: From the neutral to the target. Only a rival that is `informed` is told
                the frames between them.
            times: (T,) rising moments from 0 to 1.
            curves: The curves of the mesh; found by `extract_curves` by default.

        Returns:
            (T, V, 3) float64, in the unit of the vertices.

        Raises:
            ParameterError: The times do not rise from 0 to 1, or the recording is none.
            MeshError: It needs a surface, or one that this mesh does not have.
            CurveError: The curves belong to another mesh.
            MissingExtraError: It needs a package that is not installed.
        """
        return np.stack(list(self.told(recording, times, curves)))

    def told(
        self, recording: MeshSequence, times: ArrayLike, curves: CurveNetwork | None = None
    ) -> Faces:
        """The same face by face, each computed when it is asked for."""
        require_motion(recording)
        self.require(recording.mesh)
        moments = _as_moments(times)
        if curves is None:
            curves = extract_curves(recording.mesh)
        require_curves_of(curves, len(recording.mesh.vertices), "the recording")
        if not self.informed:
            ends = recording.frames[[0, -1]]
            recording = MeshSequence(recording.mesh, ends)
        return self.faces(recording, curves, moments)

    @abstractmethod
    def faces(
        self, recording: MeshSequence, curves: CurveNetwork, times: NDArray[np.float64]
    ) -> Faces:
        """The face at each time."""


def require_surface(mesh: Mesh) -> None:
    """Raise MeshError where a mesh has no polygons."""
    if not len(mesh.faces):
        raise MeshError("it needs a surface, which markers do not have")


def _as_moments(times: ArrayLike) -> NDArray[np.float64]:
    moments = np.atleast_1d(as_numbers(times, "times"))
    listed = moments.ndim == 1 and moments.size > 0
    if not listed or (np.diff(moments) <= 0).any() or not 0 <= moments[0] <= moments[-1] <= 1:
        raise ParameterError("times must be numbers that rise, from 0 to 1")
    return moments


def straight(recording: MeshSequence, time: float) -> NDArray[np.float64]:
    """(V, 3) the straight line from the first frame to the last."""
    first, last = recording.frames[0], recording.frames[-1]
    if time <= 0.5:  # from the nearer end, so that both are exact, and what stays does
        return np.asarray(first + time * (last - first))
    return np.asarray(last - (1.0 - time) * (last - first))
