"""Many faces in one file, written block by block: .npy, or .npz with what belongs to them."""

from __future__ import annotations

import math
import os
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import IO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import replacing, replacing_path, require_room
from elastomorph.io.npz.mesh import write_npz
from elastomorph.model.mesh import Mesh

__all__ = ["write_face_array", "write_npz_take"]

Blocks = Iterable[NDArray[np.floating]]


def write_face_array(
    path: str | Path,
    blocks: Blocks,
    shape: tuple[int, int, int],
    *,
    beside: Mapping[str, NDArray[np.generic]] | None = None,
) -> None:
    """Write (S, V, 3) float32 faces that come in (s, V, 3) blocks, one in memory at a time.

    ``.npy`` takes the faces alone, ``.npz`` the faces as ``vertices``, not compressed, and beside
    them further arrays by name, such as the weights.
    """
    suffix = Path(path).suffix.lower()
    require_room(path, 4 * math.prod(shape), f"{shape[0]:,} faces of {shape[1]:,} vertices")
    if suffix == ".npy":
        with replacing(path) as file:
            _write_npy(path, file, blocks, shape)
    elif suffix == ".npz":
        with replacing(path) as file, zipfile.ZipFile(file, "w") as archive:
            for name, array in (beside or {}).items():
                with archive.open(f"{name}.npy", "w") as member:
                    npy.write_array(member, np.asarray(array), allow_pickle=False)
            with archive.open("vertices.npy", "w", force_zip64=True) as member:
                _write_npy(path, member, blocks, shape)
    else:
        raise FormatError(path, f"many faces go into .npy or .npz, not into '{suffix}'")


def _write_npy(
    path: str | Path, file: IO[bytes], blocks: Blocks, shape: tuple[int, int, int]
) -> None:
    npy.write_array_header_2_0(file, _header(shape))
    written = 0
    for block in blocks:
        if block.shape[1:] != shape[1:]:
            raise FormatError(path, f"a block has shape {block.shape}, expected (…, {shape[1]}, 3)")
        file.write(np.ascontiguousarray(block, dtype="<f4").data)
        written += len(block)
    if written != shape[0]:
        raise FormatError(path, f"{written:,} faces came, {shape[0]:,} were expected")


def write_npz_take(
    path: str | Path,
    mesh: Mesh,
    frames: Blocks,
    times: ArrayLike,
    *,
    names: Sequence[str] = (),
    kind: str = "<f4",
) -> None:
    """Write a take, whole or not at all, in the memory of one frame.

    The archive is a mesh file of the neutral with ``frames`` (T, V, 3), float32 or of the kind
    given, ``times`` (T,) and the names of frames that have any: `read_sequence` reads the take,
    `read` the neutral. Each frame is used before the next is asked for.
    """
    beside = {"times": np.asarray(times, dtype=np.float64)}
    beside |= {"names": np.array(names, dtype=np.str_)} if names else {}
    shape = mesh.vertices.shape
    whole = (len(beside["times"]), *shape)
    size = np.dtype(kind).itemsize * math.prod(whole)
    require_room(path, size, f"{whole[0]:,} frames of {whole[1]:,} vertices")
    with replacing_path(path) as temporary:
        write_npz(temporary, mesh)
        count = 0
        with temporary.open("r+b") as file:
            with zipfile.ZipFile(file, "a") as archive:
                for name, array in beside.items():
                    with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w") as member:
                        npy.write_array(member, array, allow_pickle=False)
                info = zipfile.ZipInfo("frames.npy")  # of itself dated 1980
                with archive.open(info, "w", force_zip64=True) as member:
                    npy.write_array_header_1_0(member, _header(whole, kind))
                    for count, frame in enumerate(frames, start=1):
                        if frame.shape != shape:
                            problem = f"has the shape {frame.shape}, expected {shape}"
                            raise ParameterError(f"frame {count - 1} {problem}")
                        member.write(np.ascontiguousarray(frame, dtype=kind).tobytes())
            file.flush()
            os.fsync(file.fileno())
        if count != whole[0]:
            raise ParameterError(f"expected {whole[0]:,} frames, one a time, found {count:,}")


def _header(shape: tuple[int, ...], kind: str = "<f4") -> dict[str, object]:
    return {"descr": kind, "fortran_order": False, "shape": shape}
