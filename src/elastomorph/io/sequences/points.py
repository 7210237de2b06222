"""Named points in motion: markers, or the vertices of any other recording."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from elastomorph.io.atomic import require_name
from elastomorph.io.markers import holds_markers, read_marker_file
from elastomorph.io.sequences.recordings import read_recording
from elastomorph.model.markers import Markers

__all__ = ["read_markers"]


def read_markers(path: str | Path, *, clip: str | None = None) -> Markers:
    """Named points in motion, as they were recorded.

    Args:
        path: ``.c3d``; ``.npz`` with ``markers`` (T, M, 3), NaN where one is missing, and perhaps
            ``names`` (M,), ``times`` (T,) in seconds and ``vertices`` (M,) of the rig; or any
            motion that `read_sequence` reads, such as ``take.####.obj`` or an ``.npz`` with
            ``frames`` (T, V, 3), whose vertices are the points. Points without names are called by
            their numbers, ``0``, ``1`` and so on. Frames that the numbers of files leave out have
            no points.
        clip: As for `read_sequence`.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is not what its format allows, or of another format.
        MissingExtraError: It is .c3d and ezc3d is not installed.
        TopologyError: One mesh has other vertices or polygons than the first.
    """
    require_name(path)
    if clip is None and holds_markers(path):
        return read_marker_file(path)
    recording = read_recording(path, clip=clip)
    motion, seconds = recording.motion, recording.seconds
    frames = motion.frames
    if motion.missing and seconds is None:
        count = len(motion) + len(motion.missing)
        frames = np.full((count, *frames.shape[1:]), np.nan)
        frames[np.rint(motion.times * (count - 1)).astype(int)] = motion.frames
    times = None if seconds is None else motion.times * seconds
    return Markers(tuple(map(str, range(frames.shape[1]))), frames, times)
