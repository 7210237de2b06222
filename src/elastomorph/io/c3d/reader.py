"""Reads the markers in a C3D file."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import numpy as np

from elastomorph.errors import MissingExtraError, warn
from elastomorph.io.c3d.worker import ADVICE
from elastomorph.io.isolated import IsolatedReader, extracted
from elastomorph.model.markers import Markers

_READER = IsolatedReader("elastomorph.io.c3d.worker", "the reader of C3D files", ADVICE)
_SLOWEST = 1e-3


def read_c3d(path: str | Path) -> Markers:
    """The markers in a C3D file, in its unit and at its rate; what else was recorded is left out.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is not C3D, is damaged, has no markers, or broke its reader.
        MissingExtraError: ezc3d is not installed.
    """
    if find_spec("ezc3d") is None:
        raise MissingExtraError("ezc3d", "mocap")
    with extracted(_READER, path) as members:
        frames = members.array("positions", "f", (None, None, 3))
        names = tuple(members.texts("names", frames.shape[1]))
        announced = int(members.whole("announced", ()))
        rate = float(members.array("rate", "f", ()))
        unit = str(members.array("unit", "U", ()))
    if len(frames) < announced:
        warn(
            f"{path}: {len(frames):,} frames are in the file, which says that it has "
            f"{announced:,}; it may be cut off"
        )
    # Some programs leave the rate out.
    times = np.arange(len(frames)) / rate if _SLOWEST < rate < np.inf else None
    return Markers(names, frames, times, unit=unit or None)
