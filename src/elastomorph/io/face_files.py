"""Many faces as numbered mesh files, one after another, in constant memory."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FileError
from elastomorph.io.frame_names import frame_pattern
from elastomorph.io.registry import MESH_FORMATS, writer_of
from elastomorph.model.mesh import Mesh

__all__ = ["write_face_files"]


def write_face_files(
    pattern: str | Path, mesh: Mesh, blocks: Iterable[NDArray[np.floating]], *, first: int = 1
) -> int:
    """Write each face of a stream into a file of its own, each file whole or not at all.

    Args:
        pattern: ``face.####.obj``; the folder must exist.
        mesh: The polygons and labels of all faces.
        blocks: (s, V, 3) arrays of positions.
        first: Number of the first face.

    Returns:
        How many files were written.

    Raises:
        FileError: The name has no run of #, or a file cannot be written.
        FormatError: The suffix is unknown.
    """
    frames = frame_pattern(pattern)
    write = writer_of(pattern, MESH_FORMATS)
    if not frames.folder.is_dir():
        raise FileError(pattern, f"the folder {frames.folder} does not exist; make it first")
    number = first
    for block in blocks:
        for positions in block:
            write(frames.file(number), mesh.with_vertices(positions))
            number += 1
    return number - first
