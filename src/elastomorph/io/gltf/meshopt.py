"""Buffer views packed by meshoptimizer: EXT_meshopt_compression and KHR_meshopt_compression.

A packed view has rows of ``byteStride`` bytes; decoded it holds ``count`` of them, one after the
other. What a file says of them is checked before anything is allocated. The decoder itself refuses
streams that are damaged: it reads and writes nothing beyond its ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MissingExtraError

EXTENSIONS = ("EXT_meshopt_compression", "KHR_meshopt_compression")

_LARGEST_ROW = 256
_FILTERS = {  # the bytes that a row of them may have; None: any
    "NONE": None,
    "OCTAHEDRAL": (4, 8),
    "QUATERNION": (8,),
    "EXPONENTIAL": None,
    "COLOR": (4, 8),
}


@dataclass(frozen=True)
class Packing:
    """How a view is packed, as an extension says it; a ValueError where it cannot be so."""

    count: int  # Rows, or indices
    stride: int  # Bytes a row
    mode: str
    filter: str = "NONE"

    def __post_init__(self) -> None:
        rows = self.mode == "ATTRIBUTES"
        if self.mode not in ("ATTRIBUTES", "TRIANGLES", "INDICES"):
            raise ValueError(f"its mode is {self.mode[:40]!r}")
        if self.filter not in _FILTERS or (self.filter != "NONE" and not rows):
            raise ValueError(f"its filter is {self.filter[:40]!r} in mode {self.mode}")
        if rows and (not 4 <= self.stride <= _LARGEST_ROW or self.stride % 4):
            raise ValueError(f"its rows have {self.stride:,} bytes; expected 4 to 256, in fours")
        if not rows and self.stride not in (2, 4):
            raise ValueError(f"its indices have {self.stride:,} bytes; expected 2 or 4")
        sizes = _FILTERS[self.filter]
        if sizes is not None and self.stride not in sizes:
            raise ValueError(f"its rows have {self.stride} bytes, not fit for {self.filter}")
        if self.count < 1 or (self.mode == "TRIANGLES" and self.count % 3):
            raise ValueError(f"it has {self.count:,} {'rows' if rows else 'indices'}")

    @property
    def size(self) -> int:
        """Bytes of the decoded view."""
        return self.count * self.stride


def decoded(packing: Packing, content: memoryview) -> memoryview:
    """The rows of a packed view; a ValueError where the stream is damaged."""
    filters = {} if packing.filter == "NONE" else {"filter": packing.filter}
    try:
        found = _library().decode_gltf_buffer(
            content, packing.count, packing.stride, packing.mode, **filters
        )
    except ValueError:
        raise ValueError("its stream is damaged") from None
    return memoryview(found.tobytes())


def encode_attributes(rows: bytes | NDArray[Any], stride: int) -> bytes:
    """The stream of a view in mode ATTRIBUTES, without a filter, as EXT_meshopt_compression has it.

    Args:
        rows: The rows of the view: bytes, or an array of which each row has ``stride`` bytes.
        stride: Bytes a row: 4 to 256, in fours.

    Raises:
        MissingExtraError: The package meshopt is not installed.
        ValueError: The bytes are not whole rows, or there are none.
    """
    content = rows if isinstance(rows, bytes) else np.ascontiguousarray(rows).tobytes()
    Packing(len(content) // max(stride, 1), stride, "ATTRIBUTES")
    if len(content) % stride:
        raise ValueError(f"{len(content):,} bytes are not whole rows of {stride}")
    table = np.frombuffer(content, dtype=np.uint8).reshape(-1, stride)
    return bytes(_library().encode_gltf_buffer(table, "ATTRIBUTES"))


def encode_indices(indices: NDArray[Any], mode: str) -> bytes:
    """The stream of a view of uint16 or uint32 indices (N,), in mode TRIANGLES or INDICES.

    TRIANGLES may turn the corners of a triangle round; INDICES keeps every number where it was.
    Numbers are below 2³⁰, which is all that the second can tell apart.
    """
    return bytes(_library().encode_gltf_buffer(indices.reshape(-1), mode))


def packed_view(content: bytes, stride: int, mode: str) -> tuple[bytes, dict[str, Any]]:
    """The stream of a view, and what the extension says of it beside where the stream is.

    Args:
        content: The view: whole rows of ``stride`` bytes, or indices of 2 or 4.
        stride: Bytes a row or index.
        mode: ``ATTRIBUTES``, ``TRIANGLES`` or ``INDICES``.
    """
    if mode == "ATTRIBUTES":
        stream = encode_attributes(content, stride)
    else:
        stream = encode_indices(np.frombuffer(content, dtype=f"<u{stride}"), mode)
    return stream, {"byteStride": stride, "count": len(content) // stride, "mode": mode}


def require_meshopt() -> None:
    """Refuse, by a MissingExtraError, to go on where the package is not installed."""
    _library()


def _library() -> ModuleType:
    try:
        import meshopt
    except ModuleNotFoundError:
        raise MissingExtraError("meshopt", "gltf") from None
    library: ModuleType = meshopt
    return library
