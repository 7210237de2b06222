"""Values of a document of which nothing is refused: what is wrong is as if it were not there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from elastomorph.io.gltf.container import GltfFile

__all__ = ["entry_of", "key_of", "number_of", "numbers_of", "object_of"]


def entry_of(file: GltfFile, key: str, number: Any) -> dict[str, Any]:
    """An object of a list of the document, or an empty one."""
    items = file.document.get(key)
    if isinstance(items, list) and type(number) is int and 0 <= number < len(items):
        return object_of(items[number])
    return {}


def object_of(value: Any) -> dict[str, Any]:
    """An object, or an empty one."""
    return value if isinstance(value, dict) else {}


def key_of(value: Any) -> Any:
    """A value to look up; lists and objects are none."""
    return value if isinstance(value, int | float | str) else None


def number_of(value: Any, otherwise: float) -> float:
    """A finite number, or the other."""
    return numbers_of([value], (otherwise,))[0]


def numbers_of(values: Any, otherwise: Sequence[float]) -> list[float]:
    """As many finite numbers as there are others, or those."""
    usable = isinstance(values, list) and len(values) == len(otherwise)
    try:
        found = [float(v) for v in values if type(v) in (int, float)] if usable else []
    except OverflowError:
        found = []
    fits = len(found) == len(otherwise) and all(map(math.isfinite, found))
    return found if fits else [float(value) for value in otherwise]
