"""Which units of a data set are finished: one row of the array ``manifest`` a unit, written last.

A row of A arrays holds 1 + 2A numbers: how many faces of the unit are finished, then for each
array, in the order of the attribute ``arrays``, the bytes of its shard (0 where it holds only the
fill value and is not stored) and their CRC-32; after it stands its own CRC-32C, but in format 1.
"""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from elastomorph.farm.storage.shards import with_checksum
from elastomorph.farm.storage.stores import Objects

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
