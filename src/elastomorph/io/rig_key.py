"""What a cached rig depends on: the content of its files, the method, and the code that applied it.

Contents are hashed, not looked up by date and size: a copied, restored or synchronised file may
keep both while it changes. Hashing is far quicker than parsing, and threads share it.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields, is_dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.io.atomic import opened

__all__ = ["code_version", "content_digests", "settings_digest"]

_MOST_THREADS = 8
_BLOCK = 1 << 20


def content_digests(files: Sequence[Path]) -> tuple[str, ...]:
    """The BLAKE2b digest of the content of each file.

    Raises:
        FileError: A file is missing or cannot be read.
    """
    with ThreadPoolExecutor(min(_MOST_THREADS, os.cpu_count() or 1)) as threads:
        return tuple(threads.map(_digest_of_file, files))


def settings_digest(*settings: object) -> str | None:
    """A digest that differs wherever settings do, or None where they cannot be told apart.

    Args:
        *settings: Numbers, text, paths, arrays, curves, dataclasses, and lists and mappings of
            them. Anything else gives None: a rig that depends on it cannot be cached.
    """
    try:
        described = _described(settings)
    except _NotDescribableError:
        return None
    return _digest(json.dumps(described, ensure_ascii=True).encode())


@cache
def code_version() -> str:
    """Names the code of this package, so that what another version made is made anew."""
    try:
        released = version("elastomorph")
    except PackageNotFoundError:
        released = ""
    # A checkout changes without a new version number, so the sources themselves are hashed.
    digest = hashlib.blake2b(f"{released} numpy {np.__version__}".encode(), digest_size=16)
    for source in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()


class _NotDescribableError(TypeError):
    """A setting whose value text cannot stand for."""


def _described(value: object) -> Any:
    """The value as lists and text, different for different values."""
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, np.generic):
        return _described(value.item())
    if isinstance(value, int):
        return ["int", str(value)]
    if isinstance(value, float):
        return ["float", value.hex()]
    if isinstance(value, Path):
        return ["path", str(value)]
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufU":
        return ["array", value.dtype.str, value.shape, _digest(value.tobytes())]
    if isinstance(value, CurveNetwork):
        return ["curves", value.vertex_count, [_described(curve) for curve in value]]
    if is_dataclass(value) and not isinstance(value, type):
        own = [[field.name, _described(getattr(value, field.name))] for field in fields(value)]
        return ["object", type(value).__qualname__, own]
    if isinstance(value, Mapping):
        return ["mapping", [[_described(key), _described(own)] for key, own in value.items()]]
    if isinstance(value, Sequence) and not isinstance(value, bytes | bytearray | memoryview):
        return ["list", [_described(item) for item in value]]
    raise _NotDescribableError(f"{type(value).__name__} cannot be described")


def _digest(content: bytes) -> str:
    return hashlib.blake2b(content, digest_size=16).hexdigest()


def _digest_of_file(path: Path) -> str:
    digest = hashlib.blake2b(digest_size=16)
    with opened(path) as file:
        while block := file.read(_BLOCK):
            digest.update(block)
    return digest.hexdigest()
