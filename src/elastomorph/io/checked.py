"""Turns complaints about a mesh into complaints about the file it was read from."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

import numpy as np

from elastomorph.errors import FormatError, MeshError, ParameterError

__all__ = ["naming_file", "require_name", "shortened"]

_LONGEST = 700


def require_name(path: object) -> None:
    """Check that what should name a file can.

    Raises:
        ParameterError: It is neither a text nor a path.
    """
    if not isinstance(path, str | PathLike):
        raise ParameterError(f"a file is named by a text or a Path, found {type(path).__name__}")


@contextmanager
def naming_file(path: str | Path) -> Iterator[None]:
    """Raise a FormatError that names ``path`` where a mesh or sequence refuses what was read.

    Numbers from a file may be any; what comes of them is checked, so NumPy need not warn of them.

    Raises:
        FormatError: The content does not form a mesh or a sequence.
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
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST // 2]} … {text[-_LONGEST // 2 :]}"
