"""On which line of a settings file a key stands: TOML readers tell only where syntax fails."""

from __future__ import annotations

import re
import tomllib
from typing import Any

__all__ = ["line_of"]

_PART = r"""(?:[A-Za-z0-9_-]+|"(?:[^"\\]|\\.)*"|'[^']*')"""
_KEY = rf"{_PART}(?:[ \t]*\.[ \t]*{_PART})*"
_HEADER = re.compile(rf"[ \t]*\[{{1,2}}[ \t]*({_KEY})[ \t]*\]")
_ASSIGNMENT = re.compile(rf"[ \t]*({_KEY})[ \t]*=")


def line_of(text: str, where: tuple[str, ...]) -> int | None:
    """The line of a key or table, counted from 1; of what it is in where it has no line itself.

    Args:
        text: A document that is valid TOML.
        where: The names that lead to it, such as ``("regions", "mouth", "falloff")``.

    Returns:
        The line, or None where it cannot be told: the document has text over several lines, in
        which something may look like a key.
    """
    if '"' * 3 in text or "'" * 3 in text:
        return None
    best, found = 0, None
    table: tuple[str, ...] = ()
    for number, line in enumerate(text.split("\n"), start=1):
        if header := _HEADER.match(line):
            place = table = _names(header[1])
        elif assignment := _ASSIGNMENT.match(line):
            place = table + _names(assignment[1])
        else:
            continue
        shared = _shared(place, where)
        # A table deeper than what is asked for may be all there is of it: [a.b] is where a begins.
        if shared > best and (shared == len(place) or shared == len(where)):
            best, found = shared, number
    return found


def _names(key: str) -> tuple[str, ...]:
    content: Any = tomllib.loads(f"{key} = 0")
    names = []
    while isinstance(content, dict):
        ((name, content),) = content.items()
        names.append(name)
    return tuple(names)


def _shared(one: tuple[str, ...], other: tuple[str, ...]) -> int:
    """How many names from the first on are the same."""
    for place, (own, its) in enumerate(zip(one, other, strict=False)):
        if own != its:
            return place
    return min(len(one), len(other))
