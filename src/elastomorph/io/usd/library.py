"""Pixar's USD library, imported when the first USD file is met, and the names it may be given."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from elastomorph.errors import FileError, FormatError, MissingExtraError
from elastomorph.io.blend_shapes import different_names
from elastomorph.rig import Rig

__all__ = ["naming_failure", "prim_names", "pxr", "require_storable"]


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


def prim_names(names: Iterable[str], taken: Iterable[str] = ()) -> list[str]:
    """A valid prim name for each name, all different.

    Letters of other alphabets become underscores too: USD allows them only since 2024, and many
    programs still refuse them.

    Args:
        names: Any text.
        taken: Prim names that are not free.
    """
    plain = (re.sub(r"[^A-Za-z0-9_]", "_", name) or "_" for name in names)
    valid = (f"_{name}" if name[0].isdecimal() else name for name in plain)
    return different_names(valid, first=1, taken=set(taken))


def require_storable(path: str | Path, rig: Rig) -> None:
    """Check that USD can keep names as text beside the prim names made from them.

    Raises:
        FormatError: A name holds a NUL, at which USD would end it, or half a character.
    """
    labels = (rig.neutral.materials, rig.neutral.groups)
    for name in (*rig.morphs, *(name for own in labels if own is not None for name in own.names)):
        if "\0" in name or name.encode("utf-8", "replace").decode() != name:
            raise FormatError(path, f"the name {name!r} cannot be stored as text; rename it")
