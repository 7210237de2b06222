"""The arrays of an .npz archive, checked by their headers before anything is unpacked.

An archive is untrusted: nothing in it is ever unpickled, and it may unpack to no more than
`ALLOWANCE` bytes plus `EXPANSION` times its own size. Real arrays stay far below that; an archive
made to fill the memory does not.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.atomic import opened, replacing

__all__ = ["ALLOWANCE", "EXPANSION", "NpzMembers", "open_npz", "write_arrays"]

ALLOWANCE = 64 << 20
EXPANSION = 100


class NpzMembers:
    """An open archive whose arrays are read one by one, each only as the kind it must be."""

    def __init__(self, path: str | Path, archive: zipfile.ZipFile, limit: int) -> None:
        self._path = path
        self._archive = archive
        self._left = limit
        self.names = frozenset(
            name.removesuffix(".npy") for name in archive.namelist() if name.endswith(".npy")
        )

    def array(self, name: str, kinds: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
        """A member.

        Args:
            name: Its name.
            kinds: The NumPy dtype kinds it may have, such as ``"f"`` or ``"iu"``.
            shape: Its shape, with None for a length that is free.

        Raises:
            FormatError: It is missing, damaged, too large, or of another kind or shape.
        """
        if name not in self.names:
            raise FormatError(
                self._path,
                f"there is no array '{name}'; found {', '.join(sorted(self.names)) or 'nothing'}",
            )
        info = self._archive.getinfo(f"{name}.npy")
        self._left -= info.file_size
        if self._left < 0:
            raise FormatError(
                self._path,
                f"it would unpack to more than {ALLOWANCE >> 20} MiB plus {EXPANSION} times its "
                "own size, as no archive of a mesh does; the file is damaged or was made to harm",
            )
        with _naming_damage(self._path), self._archive.open(info) as member:
            found, kind, start = _array_header(member)
            problem = ""
            if kind.kind not in kinds:
                problem = f"has the type {kind}"
            elif len(found) != len(shape) or any(
                length is not None and length != own
                for own, length in zip(found, shape, strict=True)
            ):
                expected = tuple("any" if length is None else length for length in shape)
                problem = f"has the shape {found}, expected {expected}".replace("'", "")
            elif int(np.prod([*found, kind.itemsize], dtype=object)) != info.file_size - start:
                problem = "is shorter or longer than its header says"
            if problem:
                raise FormatError(self._path, f"the array '{name}' {problem}")
        with _naming_damage(self._path), self._archive.open(info) as member:
            array: NDArray[Any] = np.lib.format.read_array(member, allow_pickle=False)
        return array


@contextmanager
def open_npz(path: str | Path) -> Iterator[NpzMembers]:
    """Open an archive to read its arrays.

    Raises:
        FileError: The file is missing or cannot be read.
        FormatError: It is not an archive of arrays, or reading one of them fails.
    """
    with opened(path) as file:
        limit = ALLOWANCE + EXPANSION * file.seek(0, os.SEEK_END)
        with _naming_damage(path):
            archive = zipfile.ZipFile(file)
        with archive:
            yield NpzMembers(path, archive, limit)


def write_arrays(path: str | Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays as an archive that is the same, byte for byte, whenever it is written.

    Raises:
        FileError: The file cannot be written.
    """
    with replacing(path) as file, zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            info = zipfile.ZipInfo(f"{name}.npy")  # of itself dated 1980
            with archive.open(info, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)


@contextmanager
def _naming_damage(path: str | Path) -> Iterator[None]:
    try:
        yield
    except FormatError:
        raise
    except Exception as error:  # damage shows as a dozen different exceptions of three libraries
        raise FormatError(
            path, f"this is not an intact archive of arrays (.npz): {error}"
        ) from error


def _array_header(member: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[Any], int]:
    """Shape, type and first byte of the values."""
    version = np.lib.format.read_magic(member)
    if version == (1, 0):
        shape, _, kind = np.lib.format.read_array_header_1_0(member)
    elif version == (2, 0):
        shape, _, kind = np.lib.format.read_array_header_2_0(member)
    else:
        raise ValueError(f"unknown version {version} of the array format")
    return shape, kind, member.tell()
