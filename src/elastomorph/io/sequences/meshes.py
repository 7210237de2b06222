"""Motion as numbered mesh files, one a frame."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.io.atomic import (
    replacing_path,
    require_name,
    require_room,
    require_writable,
    size_of,
)
from elastomorph.io.npz.mesh import write_npz_sequence
from elastomorph.io.npz.streamed import write_npz_take
from elastomorph.io.point_cache import write_mdd, write_pc2
from elastomorph.io.registry import MESH_FORMATS, known_suffixes, read, write, writer_of
from elastomorph.io.sequences.numbering import find_frames, frame_pattern
from elastomorph.io.untrusted import MemoryBudget, naming_file
from elastomorph.model.mesh import Mesh, require_same_topology
from elastomorph.model.sequence import MeshSequence

__all__ = [
    "read_numbered",
    "require_frames",
    "write_face_files",
    "write_frames",
    "write_sequence",
]

_CACHES = {".mdd": write_mdd, ".pc2": write_pc2}

_FINEST_GRID = 10_000
_LEAST_BYTES = 12
"""Of a vertex in any mesh file: three float32 of binary PLY."""


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
    numbers = _frame_numbers(sequence.times)
    require_frames(pattern, sequence.mesh, len(numbers))
    frames.require_only(numbers)
    _write_numbered(map(frames.file, numbers), sequence.mesh, sequence.frames)


def write_frames(
    path: str | Path,
    mesh: Mesh,
    frames: Iterable[NDArray[np.float64]],
    *,
    names: Sequence[str],
) -> None:
    """Write (V, 3) frames at even steps, one a name, all or none, in the memory of one frame.

    Numbered mesh files such as ``half.####.obj``, ``.npz`` as float64 with the names, or a point
    cache, ``.mdd`` or ``.pc2``.
    """
    count, suffix = len(names), Path(path).suffix.lower()
    if "#" not in Path(path).name and suffix in _CACHES:
        _CACHES[suffix](path, frames, count=count)
    elif "#" not in Path(path).name and suffix == ".npz":
        write_npz_take(path, mesh, frames, np.linspace(0, 1, count), names=names, kind="<f8")
    else:
        pattern = frame_pattern(path)
        numbers = range(1, count + 1)
        pattern.require_only(numbers)
        _write_numbered(map(pattern.file, numbers), mesh, frames)


def require_frames(path: str | Path, mesh: Mesh, count: int) -> None:
    """Refuse what `write_frames` could not write, before the first frame is computed."""
    if "#" in Path(path).name or Path(path).suffix.lower() not in (*_CACHES, ".npz"):
        writer_of(frame_pattern(path).file(1), MESH_FORMATS)
    vertices = len(mesh.vertices)
    require_writable(path)
    require_room(
        path, _LEAST_BYTES * vertices * count, f"{count:,} frames of {vertices:,} vertices"
    )


def _write_numbered(
    files: Iterable[Path], mesh: Mesh, frames: Iterable[NDArray[np.float64]]
) -> None:
    with ExitStack() as renames:
        for file, positions in zip(files, frames, strict=True):
            temporary = renames.enter_context(replacing_path(file))
            write(temporary, mesh.with_vertices(positions))


def write_face_files(
    pattern: str | Path,
    mesh: Mesh,
    blocks: Iterable[NDArray[np.floating]],
    *,
    first: int = 1,
    count: int = 0,
) -> int:
    """Write (s, V, 3) blocks of faces, each face into a file of its own, whole or not at all.

    The pattern is as ``face.####.obj``, its folder must exist; returns the number of files. Where
    it is known how many will come, a disk that does not hold them is refused.
    """
    frames = frame_pattern(pattern)
    write = writer_of(pattern, MESH_FORMATS)
    require_frames(pattern, mesh, count)
    number = first
    for block in blocks:
        for positions in block:
            write(frames.file(number), mesh.with_vertices(positions))
            number += 1
    return number - first


def _frame_numbers(times: NDArray[np.float64]) -> list[int]:
    """Whole numbers from 1 with the distances of the times, as small as possible."""
    gaps = np.diff(times)
    for steps in range(len(times) - 1, max(_FINEST_GRID + 1, len(times))):
        if gaps.min() * steps < 0.5:
            continue
        numbers = np.rint(times * steps)
        if np.abs(times * steps - numbers).max() < 1e-6:
            return [int(number) + 1 for number in numbers]
    raise ParameterError(
        f"the {len(times)} times lie on no even grid of up to {_FINEST_GRID:,} frames, as numbered "
        "files need; write an .npz archive, which keeps them"
    )
