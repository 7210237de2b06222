"""Which units of a data set are finished: one row of the array ``manifest`` a unit, written last.

A row of A arrays holds 1 + 2A numbers: how many faces of the unit are finished, then for each
array, in the order of the attribute ``arrays``, the bytes of its shard (0 where it holds only the
fill value and is not stored) and their CRC-32; after it stands its own CRC-32C, but in format 1.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.farm.storage.stores import Objects

# Shards written in one go: chunks compressed as their rows are made, then all put in one object.
#
# The format is the codec ``sharding_indexed`` of Zarr 3: the chunks one after another, then where
# each begins and how long it is, (chunks, 2) uint64, then the CRC-32C of that index. A chunk of
# nothing but the fill value, 0, has the index 2⁶⁴ - 1 and is not there. Each chunk ends with its
# own CRC-32C, the codec ``crc32c``, so that whatever reads Zarr refuses one of which a bit has
# flipped. Zarr's own writer holds all rows of a shard, copies them several times, and reads what
# it writes over.

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


NAME = "manifest"


@dataclass(frozen=True, eq=False)
class Manifest:
    """The finished units of a data set."""

    objects: Objects
    arrays: Mapping[str, int]  # The data set's arrays in the order of the rows, and their axes
    unit: int  # Faces in a unit
    faces: int  # In all
    checked: bool = True  # Whether rows end with a checksum

    @property
    def units(self) -> int:
        """How many there are."""
        return -(-self.faces // self.unit)

    def rows(self, unit: int) -> range:
        """The faces of a unit."""
        return range(unit * self.unit, min((unit + 1) * self.unit, self.faces))

    def entry(self, unit: int) -> NDArray[np.uint64] | None:
        """The row of a unit, None where there is none or only a part of one."""
        return self._parsed(self.objects.get(f"{NAME}/c.{unit}.0"))

    def there(self, name: str, unit: int) -> int | None:
        """Finished faces of a unit in an array; None where its shard has another size than then."""
        entry = self.entry(unit)
        if entry is None:
            return 0
        size = entry[1 + 2 * list(self.arrays).index(name)]
        return int(entry[0]) if self.objects.size(self.shard(name, unit)) == size else None

    def finished(self, unit: int) -> bool:
        """Whether a unit is written whole, with shards of the sizes they had."""
        entry = self.entry(unit)
        if entry is None or entry[0] != len(self.rows(unit)):
            return False
        sizes = dict(zip(self.arrays, entry[1::2].tolist(), strict=True))
        return all(self.objects.size(self.shard(n, unit)) == size for n, size in sizes.items())

    def all_finished(self) -> set[int]:
        """The units that are written whole, in one look at what is stored."""
        there = {name: self.objects.sizes(name) for name in self.arrays}
        found = set()
        for unit, entry in self.entries().items():
            sizes = zip(self.arrays.items(), entry[1::2].tolist(), strict=True)
            if entry[0] == len(self.rows(unit)) and all(
                there[name].get(_shard_name(unit, n), 0) == size for (name, n), size in sizes
            ):
                found.add(unit)
        return found

    def entries(self) -> dict[int, NDArray[np.uint64]]:
        """The rows that there are, by unit."""
        names = [name for name in self.objects.sizes(NAME) if name.startswith("c.")]
        contents = self.objects.get_all([f"{NAME}/{name}" for name in names])
        rows = {int(n.split(".")[1]): self._parsed(c) for n, c in zip(names, contents, strict=True)}
        return {unit: row for unit, row in rows.items() if row is not None}

    def finish(self, unit: int, shards: Mapping[str, bytes]) -> int:
        """Write the row of a unit whose shards are all there; returns their bytes."""
        numbers = [[len(shards[name]), zlib.crc32(shards[name])] for name in self.arrays]
        row = np.array([len(self.rows(unit)), *np.ravel(numbers).tolist()], "<u8").tobytes()
        self.objects.put({f"{NAME}/c.{unit}.0": with_checksum(row) if self.checked else row})
        return sum(map(len, shards.values()))

    def shard(self, name: str, unit: int) -> str:
        """The key of a unit's shard of an array."""
        return f"{name}/{_shard_name(unit, self.arrays[name])}"

    def _parsed(self, content: bytes | None) -> NDArray[np.uint64] | None:
        size = 8 * (1 + 2 * len(self.arrays))
        if content is None or len(content) != size + 4 * self.checked:
            return None
        row = content[:size]
        return None if self.checked and with_checksum(row) != content else np.frombuffer(row, "<u8")


def _shard_name(unit: int, axes: int) -> str:
    """The first index of a shard is its unit; along the others there is one."""
    return f"c.{unit}" + ".0" * (axes - 1)
