"""Names that USD prims may have, made from any name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from elastomorph.errors import FormatError

__all__ = ["prim_names", "require_storable"]


def prim_names(names: Iterable[str], taken: Iterable[str] = ()) -> list[str]:
    """A valid prim name for each name, all different.

    Letters of other alphabets become underscores too: USD allows them only since 2024, and many
    programs still refuse them.

    Args:
        names: Any text.
        taken: Prim names that are not free.
    """
    used = set(taken)
    found = []
    for name in names:
        plain = re.sub(r"[^A-Za-z0-9_]", "_", name) or "_"
        if plain[0].isdecimal():
            plain = f"_{plain}"
        free, number = plain, 1
        while free in used:
            free, number = f"{plain}_{number}", number + 1
        used.add(free)
        found.append(free)
    return found


def require_storable(path: str | Path, names: Iterable[str]) -> None:
    """Check that USD can keep names as text beside the prim names made from them.

    Raises:
        FormatError: A name holds a NUL, at which USD would end it, or half a character.
    """
    for name in names:
        try:
            name.encode("utf-8")
        except UnicodeEncodeError:
            kept = False
        else:
            kept = "\0" not in name
        if not kept:
            raise FormatError(path, f"the name {name!r} cannot be stored as text; rename it")
