"""Marker takes: named points in motion, without polygons, from an .npz archive."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastomorph.errors import FormatError
from elastomorph.io.atomic import is_file
from elastomorph.io.npz.members import open_npz
from elastomorph.io.untrusted import naming_file
from elastomorph.model.mesh import Mesh
from elastomorph.model.sequence import MeshSequence

__all__ = ["MarkerTake", "holds_markers", "read_marker_take"]

_POSITIONS = ("positions", "markers", "stab")


@dataclass(frozen=True, eq=False)
class MarkerTake:
    """A take of named markers.

    Attributes:
        motion: The frames, on a mesh without polygons.
        names: The name of each marker.
    """

    motion: MeshSequence
    names: tuple[str, ...]


def holds_markers(path: str | Path) -> bool:
    """Whether a file is an archive of markers rather than of a mesh in motion."""
    if Path(path).suffix.lower() != ".npz" or not is_file(path):
        return False
    with open_npz(path) as members:
        return "names" in members.names and any(p in members.names for p in _POSITIONS)


def read_marker_take(path: str | Path) -> MarkerTake:
    """The markers of an archive of (N,) ``names`` and (T, N, 3) positions, at a constant rate.

    The rigid motion of the head is removed from these.
    """
    with open_npz(path) as members:
        called = next((p for p in _POSITIONS if p in members.names), None)
        if called is None:
            raise FormatError(
                path, f"expected (T, N, 3) positions of markers called {' or '.join(_POSITIONS)}"
            )
        frames = members.array(called, "f", (None, None, 3)).astype(np.float64)
        names = members.array("names", "U", (frames.shape[1],))
    if len(frames) < 2:
        raise FormatError(path, f"a take needs at least 2 frames, found {len(frames)}")
    with naming_file(path):
        return MarkerTake(MeshSequence(Mesh(frames[0]), frames), tuple(str(name) for name in names))
