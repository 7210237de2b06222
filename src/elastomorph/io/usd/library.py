"""Pixar's USD library, imported when the first USD file is met."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from elastomorph.errors import FileError, MissingExtraError

__all__ = ["naming_failure", "pxr"]


def pxr(module: str) -> Any:
    """A module of USD, such as ``UsdSkel``.

    Raises:
        MissingExtraError: usd-core is not installed.
    """
    try:
        return import_module(f"pxr.{module}")
    except ModuleNotFoundError as error:
        if error.name is None or error.name.partition(".")[0] != "pxr":
            raise
        raise MissingExtraError("usd-core", "usd") from None


@contextmanager
def naming_failure(path: str | Path) -> Iterator[None]:
    """Raise a FileError where USD cannot write a file.

    Raises:
        FileError: USD failed.
    """
    failure = pxr("Tf").ErrorException
    try:
        yield
    except failure as error:
        reasons = [getattr(part, "commentary", str(part)) for part in error.args]
        raise FileError(path, f"the file cannot be written: {'; '.join(reasons)}") from error
