"""Read a region: the vertices of part of a face."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.io.atomic import read_bytes
from elastomorph.io.untrusted import shortened

__all__ = ["read_region"]

_DIGITS = 9
# No mesh is as large; a mistyped range must not fill the memory.
_MOST_VERTICES = 1 << 24


def read_region(region: str | Path) -> NDArray[np.int64]:
    """Vertex indices in a JSON file, ``[3, 4]`` or ``{"vertices": […]}``, or in a text of ranges.

    Ranges are such as ``0-9408,11248``, of 16,777,216 vertices at most.
    """
    text = str(region)
    if not text.lower().endswith(".json"):
        return _ranges(text)
    try:
        content = json.loads(read_bytes(region))
    except (ValueError, RecursionError) as error:
        raise FormatError(region, f"not JSON: {shortened(error)}") from None
    if isinstance(content, dict):
        content = content.get("vertices")
    if not isinstance(content, list) or not all(
        isinstance(i, int) and not isinstance(i, bool) and 0 <= i < 2**31 for i in content
    ):
        raise FormatError(region, "expected a list of vertex indices, such as [3, 4, 5]")
    return np.array(content, dtype=np.int64)


def _ranges(text: str) -> NDArray[np.int64]:
    parts: list[NDArray[np.int64]] = []
    count = 0
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not _is_index(first) or (dash and not _is_index(last)):
            raise ParameterError(
                f"region {_shown(text)}: expected a .json file or ranges such as 0-9408,11248"
            )
        start, stop = int(first), int(last) if dash else int(first)
        count += stop + 1 - start
        if stop < start or count > _MOST_VERTICES:
            raise ParameterError(
                f"region {_shown(text)}: the range {_shown(part.strip())} is empty or too large"
            )
        parts.append(np.arange(start, stop + 1))
    return np.concatenate(parts)


def _is_index(text: str) -> bool:
    return text.isdecimal() and text.isascii() and len(text) <= _DIGITS


def _shown(text: str) -> str:
    return repr(text if len(text) <= 60 else text[:60] + "…")
