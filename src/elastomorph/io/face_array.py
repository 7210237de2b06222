"""Many faces in one file, written block by block: .npy, or .npz with their weights."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import IO

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.atomic import replacing

__all__ = ["write_face_array"]


def write_face_array(
    path: str | Path,
    blocks: Iterable[NDArray[np.floating]],
    shape: tuple[int, int, int],
    *,
    beside: Mapping[str, NDArray[np.generic]] | None = None,
) -> None:
    """Write (S, V, 3) float32 faces that come in blocks; memory holds one block at a time.

    Args:
        path: ``.npy``: the faces alone. ``.npz``: the faces as ``vertices``, not compressed, and
            what comes beside them.
        blocks: (s, V, 3) arrays, S faces in all.
        shape: (S, V, 3).
        beside: Further arrays for ``.npz`` by name, such as the weights.

    Raises:
        FormatError: Another suffix, or the blocks do not make up S faces.
        FileError: The file cannot be written.
    """
    suffix = Path(path).suffix.lower()
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
    path: str | Path,
    file: IO[bytes],
    blocks: Iterable[NDArray[np.floating]],
    shape: tuple[int, int, int],
) -> None:
    header = {"descr": "<f4", "fortran_order": False, "shape": shape}
    npy.write_array_header_2_0(file, header)
    written = 0
    for block in blocks:
        if block.shape[1:] != shape[1:]:
            raise FormatError(path, f"a block has shape {block.shape}, expected (…, {shape[1]}, 3)")
        file.write(np.ascontiguousarray(block, dtype="<f4").data)
        written += len(block)
    if written != shape[0]:
        raise FormatError(path, f"{written:,} faces came, {shape[0]:,} were expected")
