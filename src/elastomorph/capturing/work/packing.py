"""Results of stages as arrays of an archive, and back.

A result is made of frozen dataclasses of this room, mappings, tuples, lists, arrays, numbers and
texts. Arrays become members of the archive; all else is one text of JSON that says where each of
them belongs. Nothing is ever unpickled: of classes, only dataclasses of this room are made.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from hashlib import blake2b
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.io.npz.members import NpzMembers

_LAYOUT = "layout"
_ROOM = "elastomorph.capturing"
_SCALARS = (bool, int, str, type(None))


def packed(value: object) -> dict[str, NDArray[Any]]:
    """A result as arrays."""
    arrays: dict[str, NDArray[Any]] = {}
    layout = _described(value, arrays)
    arrays[_LAYOUT] = np.array(json.dumps(layout, ensure_ascii=True))
    return arrays


def unpacked(members: NpzMembers) -> Any:
    """The result that arrays of an archive were packed from.

    Raises:
        FormatError: The archive holds something else.
    """
    try:
        return _restored(json.loads(str(members.array(_LAYOUT, "U", ()))), members)
    except (ValueError, KeyError, TypeError, AttributeError, ImportError, RecursionError) as error:
        raise FormatError(members.path, f"it holds no result of a stage: {error}") from error


def content_digest(arrays: Mapping[str, NDArray[Any]]) -> str:
    """A digest that differs wherever packed results do."""
    digest = blake2b(digest_size=16)
    for name, array in arrays.items():
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _described(value: Any, arrays: dict[str, NDArray[Any]]) -> Any:
    """What stands for a value in JSON: a scalar itself, anything else as [kind, content]."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, _SCALARS):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else ["float", repr(value)]
    if isinstance(value, Path):
        return ["path", str(value)]
    if isinstance(value, np.ndarray):
        name = f"array{len(arrays)}"
        arrays[name] = value
        return ["array", name, value.dtype.kind, value.ndim]
    if isinstance(value, Mapping):
        pairs = [[_described(part, arrays) for part in pair] for pair in value.items()]
        return ["mapping", pairs]
    if isinstance(value, tuple | list):
        kind = "tuple" if isinstance(value, tuple) else "list"
        return [kind, [_described(part, arrays) for part in value]]
    if is_dataclass(value) and not isinstance(value, type):
        own = type(value)
        content = {
            each.name: _described(getattr(value, each.name), arrays)
            for each in fields(value)
            if each.init
        }
        return ["object", own.__module__, own.__qualname__, content]
    raise TypeError(f"a result of a stage cannot hold {type(value).__name__}")


def _restored(described: Any, members: NpzMembers) -> Any:
    if not isinstance(described, list):
        return described
    kind, *content = described
    if kind == "array":
        name, type_of, size = content
        return members.array(name, type_of, (None,) * size)
    if kind == "object":
        module, name, values = content
        made = _class_of(module, name)
        return made(**{key: _restored(value, members) for key, value in values.items()})
    if kind == "mapping":
        return {_restored(key, members): _restored(value, members) for key, value in content[0]}
    if kind in ("tuple", "list"):
        parts = [_restored(part, members) for part in content[0]]
        return tuple(parts) if kind == "tuple" else parts
    return {"float": float, "path": Path}[kind](content[0])


def _class_of(module: str, name: str) -> Any:
    """A dataclass of this room by its name."""
    found = getattr(import_module(module), name) if f"{module}.".startswith(f"{_ROOM}.") else None
    if not (isinstance(found, type) and is_dataclass(found)):
        raise ValueError(f"{module}.{name} is no result")
    return found
