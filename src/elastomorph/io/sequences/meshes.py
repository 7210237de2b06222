"""Motion as numbered mesh files, one a frame."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FileError, ParameterError
from elastomorph.io.atomic import replacing_path, require_name, size_of
from elastomorph.io.npz.mesh import write_npz_sequence
from elastomorph.io.registry import MESH_FORMATS, known_suffixes, read, writer_of
from elastomorph.io.sequences.numbering import find_frames, frame_pattern
from elastomorph.io.untrusted import MemoryBudget, naming_file
from elastomorph.model.mesh import Mesh, require_same_topology
from elastomorph.model.sequence import MeshSequence

__all__ = ["read_numbered", "write_face_files", "write_sequence"]

_FINEST_GRID = 10_000


def read_numbered(pattern: str | Path) -> MeshSequence:
    """The frames in numbered mesh files or a folder of them, in the order of their numbers."""
    found = find_frames(pattern, known_suffixes(MESH_FORMATS))
    first = read(found.files[0])
    budget = MemoryBudget(pattern, sum(map(size_of, found.files)))
    budget.spend_fields(len(first.vertices), len(found.files))
    frames = np.empty((len(found.files), *first.vertices.shape))
    frames[0] = first.vertices
    for i, file in enumerate(found.files[1:], start=1):
        mesh = read(file)
        require_same_topology(first, mesh)
        frames[i] = mesh.vertices
    frames.flags.writeable = False  # a motion takes such frames as they are
    numbers = [float(number - found.numbers[0]) for number in found.numbers]
    with naming_file(pattern):
        return MeshSequence(
            first, frames, numbers, [file.name for file in found.files], found.missing
        )


def write_sequence(pattern: str | Path, sequence: MeshSequence) -> None:
    """Write a recorded motion, all frames or none.

    All frames are written under temporary names and only then renamed. Frames are numbered from 1
    by their times, so that a motion with a gap is read back with that gap.

    Args:
        pattern: ``scan.####.obj``, with as many # as numbers should have digits, or one ``.npz``
            archive, which keeps times and names as they are. The folder must exist.
        sequence: The motion.

    Raises:
        FileError: A file cannot be written, or files of another motion match the pattern and
            would mix with this one.
        FormatError: The suffix is unknown.
        ParameterError: The times lie on no even grid of frames; only an archive can hold them.
    """
    if not isinstance(sequence, MeshSequence):
        raise ParameterError(f"expected a MeshSequence, found {type(sequence).__name__}")
    require_name(pattern)
    path = Path(pattern)
    if path.suffix.lower() == ".npz" and "#" not in path.name:
        write_npz_sequence(pattern, sequence)
        return
    frames = frame_pattern(pattern)
    write = writer_of(pattern, MESH_FORMATS)
    files = [frames.file(number) for number in _frame_numbers(sequence.times)]
    frames.require_only(files)
    with ExitStack() as renames:
        for file, mesh in zip(files, sequence, strict=True):
            write(renames.enter_context(replacing_path(file)), mesh)


def write_face_files(
    pattern: str | Path, mesh: Mesh, blocks: Iterable[NDArray[np.floating]], *, first: int = 1
) -> int:
    """Write (s, V, 3) blocks of faces, each face into a file of its own, whole or not at all.

    The pattern is as ``face.####.obj``, its folder must exist; returns the number of files.
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


def _frame_numbers(times: NDArray[np.float64]) -> list[int]:
    """Whole numbers from 1 with the distances of the times, as small as possible."""
    gaps = np.diff(times)
    for steps in range(len(times) - 1, _FINEST_GRID + 1):
        if gaps.min() * steps < 0.5:
            continue
        numbers = np.rint(times * steps)
        if np.abs(times * steps - numbers).max() < 1e-6:
            return [int(number) + 1 for number in numbers]
    raise ParameterError(
        f"the {len(times)} times lie on no even grid of up to {_FINEST_GRID:,} frames, as numbered "
        "files need; write an .npz archive, which keeps them"
    )
