"""How much memory a file may take: in proportion to its size, so that none can fill the machine.

A few bytes can announce or unpack to gigabytes. What is about to be used is counted beforehand,
with the copies that reading makes of it, and a file that asks for more than it may is refused: 32
MiB, 192 times its size up to a megabyte, and 512 times what it has beyond. Real files stay far
below that, and one under a megabyte takes at most 256 MB.
"""

from __future__ import annotations

from pathlib import Path

from elastomorph.errors import FormatError

__all__ = ["MemoryBudget", "allowed_memory"]

_BASE = 32 << 20
_SMALL = 1_000_000
_TIMES_SMALL, _TIMES_LARGE = 192, 512

# A target or a mesh is a handful of objects, however little it moves or shows.
_BYTES_OF_OBJECTS = 12 << 10
_BYTES_OF_LOOKUP = 4
_MORE_THAN_DENSE = 1.1


def allowed_memory(size: int) -> int:
    """Bytes of memory that reading a file of ``size`` bytes may take."""
    return _BASE + _TIMES_SMALL * min(size, _SMALL) + _TIMES_LARGE * max(0, size - _SMALL)


class MemoryBudget:
    """Counts what a file takes of the memory it may."""

    def __init__(self, path: str | Path, size: int) -> None:
        self._path = path
        self._size = size
        self._spent = 0.0

    def add_size(self, size: int) -> None:
        """Bytes of another file that belongs to this one."""
        self._size += size

    def spend(self, amount: float) -> None:
        """Count bytes of memory about to be used.

        Raises:
            FormatError: The file asks for more than it may.
        """
        self._spent += amount
        allowed = allowed_memory(self._size)
        if self._spent > allowed:
            raise FormatError(
                self._path,
                f"it would take more memory than {allowed >> 20:,} MiB, as no face in a file of "
                f"{self._size:,} bytes does; it is damaged or was made to harm",
            )

    def spend_objects(self, count: int) -> None:
        """Count things that each take some memory and time, such as targets or meshes.

        Raises:
            FormatError: As `spend`.
        """
        self.spend(_BYTES_OF_OBJECTS * count)

    def spend_lookups(self, entries: int, names: int) -> None:
        """Count entries of groups and correctives, each of which is looked up among the names.

        Raises:
            FormatError: As `spend`; what is spent here is time, as if it were memory.
        """
        self.spend(_BYTES_OF_LOOKUP * entries * names)

    def spend_fields(self, vertices: int, fields: int, copies: int = 1) -> None:
        """Count (V, 3) float64 fields, such as the targets and bends of a rig.

        Args:
            vertices: V.
            fields: How many there are.
            copies: How often each is held at the same time.

        Raises:
            FormatError: As `spend`.
        """
        self.spend_objects(fields)
        self.spend(_MORE_THAN_DENSE * 24 * vertices * fields * copies)
