"""What every reader holds files to, for they may be damaged or made to harm.

A few bytes can announce or unpack to gigabytes. What is about to be used is counted beforehand,
with the copies that reading makes of it, and a file that asks for more than it may is refused: 32
MiB, 192 times its size up to a megabyte, and 512 times what it has beyond. Real files stay far
below that, and one under a megabyte takes at most 256 MB. Complaints name the file, in short.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from elastomorph.errors import FormatError, MeshError, ParameterError
from elastomorph.io.atomic import opened

_BASE = 32 << 20
_SMALL = 1_000_000
_TIMES_SMALL, _TIMES_LARGE = 192, 512

# A target or a mesh is a handful of objects, however little it moves or shows.
_BYTES_OF_OBJECTS = 12 << 10
_BYTES_OF_LOOKUP = 4
_MORE_THAN_DENSE = 1.1

_LONGEST_MESSAGE = 700


def allowed_memory(size: int) -> int:
    """Bytes of memory that reading a file of ``size`` bytes may take."""
    return _BASE + _TIMES_SMALL * min(size, _SMALL) + _TIMES_LARGE * max(0, size - _SMALL)


class MemoryBudget:
    """Counts what a file takes of the memory it may.

    Every way to spend raises a FormatError where the file asks for more than it may.
    """

    def __init__(self, path: str | Path, size: int) -> None:
        self._path = path
        self._size = size
        self._spent = 0.0
        self._briefly = 0.0

    def add_size(self, size: int) -> None:
        """Bytes of another file that belongs to this one."""
        self._size += size

    def spend(self, amount: float) -> None:
        """Count bytes of memory about to be used."""
        self._spent += amount
        allowed = allowed_memory(self._size)
        if self._spent > allowed:
            raise FormatError(
                self._path,
                f"it would take more memory than {allowed >> 20:,} MiB, as no face in a file of "
                f"{self._size:,} bytes does; it is damaged or was made to harm",
            )

    def spend_briefly(self, amount: float) -> None:
        """Count bytes of memory that are given back before the next are used: the most of them."""
        more = amount - self._briefly
        if more > 0:
            self._briefly = amount
            self.spend(more)

    def spend_objects(self, count: int) -> None:
        """Count things that each take some memory and time, such as targets or meshes."""
        self.spend(_BYTES_OF_OBJECTS * count)

    def spend_lookups(self, entries: int, names: int) -> None:
        """Count entries of groups and correctives, each looked up among the names.

        What is spent here is time, as if it were memory.
        """
        self.spend(_BYTES_OF_LOOKUP * entries * names)

    def spend_fields(self, vertices: int, fields: int, copies: int = 1) -> None:
        """Count (V, 3) float64 fields, such as the targets and bends of a rig."""
        self.spend_objects(fields)
        self.spend(_MORE_THAN_DENSE * 24 * vertices * fields * copies)


@contextmanager
def naming_file(path: str | Path) -> Iterator[None]:
    """Raise a FormatError that names ``path`` where a mesh or sequence refuses what was read.

    Numbers from a file may be any; what comes of them is checked, so NumPy need not warn of them.
    """
    try:
        with np.errstate(all="ignore"):
            yield
    except (MeshError, ParameterError) as error:
        raise FormatError(
            path, f"{shortened(error)}; the file is damaged or was written wrongly"
        ) from error


def shortened(problem: object) -> str:
    """A message without the middle of it where a name in it, which may be any, is very long."""
    text = str(problem).encode("utf-8", "backslashreplace").decode()
    half = _LONGEST_MESSAGE // 2
    return text if len(text) <= _LONGEST_MESSAGE else f"{text[:half]} … {text[-half:]}"


# Files that only stand for what was meant, whatever their names say: it has yet to be fetched.

_LONGEST = 200
_KINDS = (
    (
        re.compile(rb"version https://git-lfs"),
        "this is the pointer of Git LFS to a file, not the file itself; fetch it with 'git lfs "
        "pull'",
    ),
    (
        re.compile(rb"(\xef\xbb\xbf)?\s*<(!doctype\s+)?html", re.IGNORECASE),
        "this is a web page, perhaps one that asks to sign in; download the file itself",
    ),
)


def require_meant(path: str | Path) -> None:
    """Refuse a file that stands for another one.

    Raises:
        FileError: It cannot be read.
        FormatError: It is a pointer of Git LFS or a web page.
    """
    with opened(Path(path)) as file:
        refuse_mistaken(path, file.read(_LONGEST))


def refuse_mistaken(path: str | Path, start: bytes) -> None:
    """As `require_meant`, of a file that begins with these bytes."""
    for kind, words in _KINDS:
        if kind.match(start):
            raise FormatError(path, words)
