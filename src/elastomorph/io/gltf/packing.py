"""Long lists of whole numbers as short texts, for the JSON part of a file.

The differences of neighbours, as little-endian 32-bit integers modulo 2³², compressed with zlib
and written in base64: a list that rises by one costs next to nothing.
"""

from __future__ import annotations

import base64
import binascii
import zlib
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["packed", "packed_bytes", "unpacked", "unpacked_bytes"]


def packed(integers: ArrayLike) -> str:
    """A list of int32 as text.

    Args:
        integers: (N,) between -2³¹ and 2³¹ - 1.
    """
    values = np.asarray(integers, dtype=np.int64)
    return packed_bytes(np.diff(values, prepend=0).astype("<u4").tobytes())


def unpacked(text: Any, count: int) -> NDArray[np.int32]:
    """The list in a text.

    Args:
        text: What `packed` wrote.
        count: How many numbers it must hold.

    Returns:
        (count,) int32.

    Raises:
        ValueError: It is no such text, or holds another number of numbers.
    """
    differences = np.frombuffer(unpacked_bytes(text, 4 * count), dtype="<u4")
    return np.cumsum(differences, dtype=np.uint32).view(np.int32)


def packed_bytes(content: bytes) -> str:
    """Bytes, compressed, as text."""
    return base64.b64encode(zlib.compress(content, 9)).decode("ascii")


def unpacked_bytes(text: Any, length: int) -> bytes:
    """The bytes in a text; no more than ``length`` are ever unpacked.

    Raises:
        ValueError: It is no such text, or holds another number of bytes.
    """
    if not isinstance(text, str):
        raise ValueError("expected a packed text")
    try:
        unpacker = zlib.decompressobj()
        content = unpacker.decompress(base64.b64decode(text, validate=True), length + 1)
    except (binascii.Error, zlib.error, ValueError) as error:
        raise ValueError(f"a packed text is damaged: {error}") from None
    if len(content) != length:
        raise ValueError(f"a packed text holds more or fewer than {length:,} bytes")
    return content
