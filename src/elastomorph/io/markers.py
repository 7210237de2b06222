"""Files of markers, as they were recorded: .c3d, and .npz.

An archive has (T, N, 3) positions, and perhaps (N,) ``names``, ``times`` and ``vertices``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, warn
from elastomorph.io.atomic import is_file
from elastomorph.io.c3d import read_c3d
from elastomorph.io.npz.members import NpzMembers, open_npz
from elastomorph.model.markers import Markers
from elastomorph.model.mesh import LARGEST

__all__ = ["holds_markers", "read_marker_file"]

_SLOW = 1.0  # Seconds a frame
_POSITIONS = ("positions", "markers", "stab")


def holds_markers(path: str | Path) -> bool:
    """Whether a file is one of markers rather than of a mesh in motion."""
    suffix = Path(path).suffix.lower()
    if suffix != ".npz" or not is_file(path):
        return suffix == ".c3d"
    with open_npz(path) as members:
        return any(p in members.names for p in _POSITIONS)


def read_marker_file(path: str | Path) -> Markers:
    """The markers of a file that holds some, where the head was and with gaps."""
    taken = read_c3d(path) if Path(path).suffix.lower() == ".c3d" else _read_archive(path)
    if not taken.frames.size:
        raise FormatError(
            path,
            f"it has no positions of markers: {len(taken):,} frames of {len(taken.names)} markers",
        )
    for name, place in zip(taken.names, np.moveaxis(taken.frames, 1, 0), strict=True):
        if (np.abs(place) > LARGEST).any():
            raise FormatError(
                path,
                f"the marker {name:.40} has positions beyond {LARGEST:g}; the file is damaged, or "
                "has other numbers than NaN where a marker is missing",
            )
    return taken


def _read_archive(path: str | Path) -> Markers:
    with open_npz(path) as members:
        called = next((p for p in _POSITIONS if p in members.names), None)
        if called is None:
            raise FormatError(
                path, f"expected (T, N, 3) positions of markers called {' or '.join(_POSITIONS)}"
            )
        frames = members.array(called, "fiu", (None, None, 3)).astype(np.float64)
        count = frames.shape[1]
        named = "names" in members.names
        names = members.texts("names", count) if named else [str(i) for i in range(count)]
        times = _times(members, len(frames))
        vertices = None
        if "vertices" in members.names:
            vertices = tuple(members.whole("vertices", (count,)).tolist())
    return Markers(tuple(names), frames, times, vertices)


def _times(members: NpzMembers, count: int) -> NDArray[np.float64] | None:
    """Seconds of the frames, where they are said."""
    if "times" not in members.names:
        return None
    times = members.array("times", "fiu", (count,)).astype(np.float64)
    if not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise FormatError(members.path, "its times must be finite numbers that rise")
    step = float(np.median(np.diff(times))) if count > 1 else 0.0
    if step >= _SLOW:
        warn(
            f"{members.path}: its times are taken as seconds, so that a frame lasts {step:.4g} s; "
            "milliseconds and numbers of frames must be made seconds"
        )
    return times
