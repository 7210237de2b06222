"""Shards written in one go: chunks compressed as their rows are made, then all put in one object.

The format is the codec ``sharding_indexed`` of Zarr 3: the chunks one after another, then where
each begins and how long it is, (chunks, 2) uint64, then the CRC-32C of that index. A chunk of
nothing but the fill value, 0, has the index 2⁶⁴ - 1 and is not there. Each chunk ends with its own
CRC-32C, the codec ``crc32c``, so that whatever reads Zarr refuses one of which a bit has flipped.
Zarr's own writer holds all rows of a shard, copies them several times, and reads what it writes
over.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError

Pack = Callable[[NDArray[Any]], bytes]

CODECS: Mapping[str, Mapping[str, Any] | None] = {
    "lz4": {"cname": "lz4", "clevel": 1},
    "zstd": {"cname": "zstd", "clevel": 3},
    "none": None,
}
"""How chunks are compressed: Blosc with a shuffle of bytes, or not at all."""

_NOT_THERE = 2**64 - 1


def require_codec(name: str) -> None:
    """Refuse a codec that there is not."""
    if name not in CODECS:
        raise ParameterError(f"chunks are compressed by {', '.join(CODECS)}, not {name!r}")


def zarr_codecs(name: str) -> list[Any]:
    """The codecs of a chunk as Zarr names them in an array's metadata."""
    from zarr.codecs import BloscCodec, Crc32cCodec

    settings = CODECS[name]
    packed = [] if settings is None else [BloscCodec(**settings, shuffle="shuffle")]
    return [*packed, Crc32cCodec()]


def packing(name: str, *, checked: bool) -> Pack:
    """Return what makes the bytes of a chunk, with a checksum or, in format 1, without."""
    settings = CODECS[name]
    if settings is None:
        pack: Pack = lambda rows: rows.tobytes()  # noqa: E731
    else:
        from numcodecs import Blosc, blosc

        blosc.use_threads = False  # several would put the blocks in another order each time
        pack = Blosc(**settings, shuffle=Blosc.SHUFFLE).encode
    return (lambda rows: with_checksum(pack(rows))) if checked else pack


def with_checksum(content: bytes) -> bytes:
    """Return the content with its CRC-32C, as Zarr's codec ``crc32c`` writes it."""
    from google_crc32c import value

    checksum: int = value(content)
    return content + checksum.to_bytes(4, "little")


class Shard:
    """A shard being made of an array, row by row.

    Args:
        rows: How many the shard has room for.
        chunk: How many are compressed together, a divisor of the rows.
        pack: How.
    """

    def __init__(self, rows: int, chunk: int, pack: Pack) -> None:
        self.chunk, self.pack = chunk, pack
        self._index = np.full((rows // chunk, 2), _NOT_THERE, np.uint64)
        self._packed: list[bytes] = []
        self._size = self._count = 0
        self._waiting: list[NDArray[Any]] = []
        self._waited = 0

    def add(self, rows: NDArray[Any]) -> None:
        """Add the next rows."""
        while len(rows):
            room = self.chunk - self._waited
            self._waiting.append(rows[:room])
            self._waited += len(rows[:room])
            rows = rows[room:]
            if self._waited == self.chunk:
                self._close()

    def content(self) -> bytes:
        """The bytes of the shard; what it has no rows for is the fill value. None: nothing is."""
        if self._waited:
            last = self._waiting[-1]
            self._waiting.append(np.zeros((self.chunk - self._waited, *last.shape[1:]), last.dtype))
            self._close()
        if not self._packed:
            return b""
        return b"".join([*self._packed, with_checksum(self._index.astype("<u8").tobytes())])

    def _close(self) -> None:
        """Compress the rows that wait."""
        whole = self._waiting[0] if len(self._waiting) == 1 else np.concatenate(self._waiting)
        if whole.any():
            packed = self.pack(np.ascontiguousarray(whole))
            self._index[self._count] = self._size, len(packed)
            self._packed.append(packed)
            self._size += len(packed)
        self._count += 1
        self._waiting, self._waited = [], 0
