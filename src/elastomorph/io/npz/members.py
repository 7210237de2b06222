"""The arrays of an .npz archive, checked by their headers before anything is unpacked.

An archive is untrusted. Nothing in it is ever unpickled; members are unpacked only as numbers or
text of the shape asked for, and only as much of them as a `MemoryBudget` allows. Of the ways to
pack a member those two that NumPy writes are read: other ones unpack without bounds.
"""

from __future__ import annotations

import os
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.atomic import opened, replacing
from elastomorph.io.untrusted import MemoryBudget

_PACKED_AS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)

# Bytes an element takes beside those in the archive: float64 copies and what checks them, or a
# text of Python.
_COPIES = {"U": 80}
_COPIES_OF_NUMBERS = 20
_LONGEST_LIST = 12


class NpzMembers:
    """An open archive whose arrays are read one by one, each only as the kind it must be.

    Attributes:
        path: The archive as the user named it.
        names: Names of the arrays.
        budget: Memory that the file may still take.
    """

    def __init__(self, path: str | Path, archive: zipfile.ZipFile, budget: MemoryBudget) -> None:
        self.path = path
        self._archive = archive
        self.budget = budget
        self.names = frozenset(
            name.removesuffix(".npy") for name in archive.namelist() if name.endswith(".npy")
        )

    def array(self, name: str, kinds: str, shape: tuple[int | None, ...]) -> NDArray[Any]:
        """A member of one of these NumPy dtype kinds and of this shape; None is any length."""
        if name not in self.names:
            raise FormatError(self.path, f"there is no array '{name}'; found {self.listed()}")
        info = self._archive.getinfo(f"{name}.npy")
        if info.compress_type not in _PACKED_AS:
            raise FormatError(
                self.path, f"the array '{name}' is packed in a way that NumPy does not write"
            )
        with _naming_damage(self.path), self._archive.open(info) as member:
            found, kind, start = _array_header(member)
        if (
            kind.kind not in kinds
            or not kind.itemsize
            or (kind.itemsize > 8 and kind.kind in "fiu")
        ):
            self._refuse(name, f"has the type {kind}")
        if len(found) != len(shape) or any(
            length is not None and length != own for own, length in zip(found, shape, strict=True)
        ):
            expected = tuple("any" if length is None else length for length in shape)
            self._refuse(name, f"has the shape {found}, expected {expected}".replace("'", ""))
        count = int(np.prod([1, *found], dtype=object))
        if count < 0 or count * kind.itemsize != info.file_size - start:
            self._refuse(name, "is shorter or longer than its header says")
        self.budget.spend(info.file_size + count * _COPIES.get(kind.kind, _COPIES_OF_NUMBERS))
        with _naming_damage(self.path), self._archive.open(info) as member:
            array: NDArray[Any] = np.lib.format.read_array(member, allow_pickle=False)
        if kind.kind == "U" and not _is_text(array):
            self._refuse(name, "holds text with characters that do not exist")
        return array

    def whole(
        self, name: str, shape: tuple[int | None, ...], lowest: int = 0, highest: int | None = None
    ) -> NDArray[Any]:
        """A member of whole numbers in a range, such as indices or counts."""
        values = self.array(name, "iu", shape)
        if values.size:
            least, most = int(values.min()), int(values.max())
            if least < lowest or (highest is not None and most > highest):
                expected = (
                    f"{lowest:,} and more" if highest is None else f"{lowest:,} to {highest:,}"
                )
                self._refuse(
                    name,
                    f"goes from {least:,} to {most:,}, expected {expected}; the file is damaged",
                )
        return values

    def texts(self, name: str, count: int | None = None) -> list[str]:
        """A member of texts, one after another; ``count`` of them, or any number."""
        found: list[str] = self.array(name, "U", (count,)).tolist()
        return found

    def listed(self) -> str:
        """Some of the names, each short, as a damaged archive may have any."""
        names = sorted(self.names)
        shown = [name[:40].encode("ascii", "backslashreplace").decode() for name in names]
        rest = len(shown) - _LONGEST_LIST
        if rest > 0:
            shown[_LONGEST_LIST:] = [f"{rest:,} more"]
        return ", ".join(shown) or "nothing"

    def _refuse(self, name: str, problem: str) -> NoReturn:
        raise FormatError(self.path, f"the array '{name}' {problem}")


@contextmanager
def open_npz(path: str | Path, budget: MemoryBudget | None = None) -> Iterator[NpzMembers]:
    """Open an archive to read its arrays."""
    with opened(path) as file:
        own = budget or MemoryBudget(path, file.seek(0, os.SEEK_END))
        with _naming_damage(path):
            archive = zipfile.ZipFile(file)
        with archive:
            yield NpzMembers(path, archive, own)


def write_arrays(path: str | Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays as an archive that is the same, byte for byte, whenever it is written."""
    with replacing(path) as file:
        pack_arrays(file, arrays)


def pack_arrays(file: IO[bytes], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays as an archive into an open file."""
    with zipfile.ZipFile(file, "w") as archive:
        for name, array in arrays.items():
            info = zipfile.ZipInfo(f"{name}.npy")  # of itself dated 1980
            with archive.open(info, "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asarray(array), allow_pickle=False)


@contextmanager
def _naming_damage(path: str | Path) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # damage shows as a dozen different exceptions of three libraries
        said = str(error).encode("ascii", "backslashreplace").decode()[:200]
        raise FormatError(
            path, f"this is not an intact archive of arrays (.npz): {said}"
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


def _is_text(array: NDArray[Any]) -> bool:
    """Whether all characters exist, which NumPy does not ask, and halves of one are not alone."""
    native = array.astype(array.dtype.newbyteorder("="), copy=False)
    codes = np.frombuffer(native.tobytes(), dtype=np.uint32)
    return not ((codes > 0x10FFFF) | ((codes >= 0xD800) & (codes <= 0xDFFF))).any()
