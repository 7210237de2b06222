"""Turns complaints about a mesh into complaints about the file it was read from."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from elastomorph.errors import FormatError, MeshError, ParameterError

__all__ = ["naming_file"]


@contextmanager
def naming_file(path: str | Path) -> Iterator[None]:
    """Raise a FormatError that names ``path`` where a mesh or sequence refuses what was read.

    Raises:
        FormatError: The content does not form a mesh or a sequence.
    """
    try:
        yield
    except (MeshError, ParameterError) as error:
        raise FormatError(path, f"{error}; the file is damaged or was written wrongly") from error
