"""What a command has read is not what it writes over.

Files are known by their identity on the disk, so links of either kind make no difference. Only the
command line keeps its inputs: a program that calls us may well mean what it says.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from os import stat_result
from pathlib import Path

from elastomorph.errors import FileError

__all__ = ["inputs_kept", "note_input", "note_output", "require_no_input", "unnoted"]

Identity = tuple[int, int]

# Of each command that is running, the innermost last, what it has read and what it has written; of
# the process, for threads read too.
_noted: list[tuple[set[Identity], set[Identity]]] = []


@contextmanager
def inputs_kept() -> Iterator[None]:
    """Refuse, from here on, to write over a file that was read."""
    _noted.append((set(), set()))
    try:
        yield
    finally:
        _noted.pop()


@contextmanager
def unnoted() -> Iterator[None]:
    """Read and write what is nobody's input, such as a cache."""
    before = _noted[:]
    _noted.clear()
    try:
        yield
    finally:
        _noted[:] = before


def note_input(found: stat_result) -> None:
    """Remember a file that is being read, unless this command has written it."""
    if _noted and _identity(found) not in _noted[-1][1]:
        _noted[-1][0].add(_identity(found))


def note_output(final: Path) -> None:
    """Remember a file that was written: it may be read and written again."""
    if _noted:
        with suppress(OSError):
            _noted[-1][1].add(_identity(final.stat()))


def require_no_input(path: str | Path, final: Path) -> None:
    """Refuse to write over a file that was read."""
    if not _noted:
        return
    try:
        there = _identity(final.stat())
    except OSError:
        return
    if there in _noted[-1][0]:
        raise FileError(
            path,
            "this file was read as an input and is not written over; name another output, or add "
            "--overwrite",
        )


def _identity(found: stat_result) -> Identity:
    return found.st_dev, found.st_ino
