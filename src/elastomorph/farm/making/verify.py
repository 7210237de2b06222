"""A data set looked at again: some units are made anew and compared with what is stored."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.farm.making.unit import unit_rows
from elastomorph.farm.storage.layout import DataSet
from elastomorph.farm.storage.stores import naming_damage, naming_store, order_of
from elastomorph.numbers import is_whole

# Another processor rounds sums otherwise: codes by a step, numbers by this part of the largest.
_ROUNDED = 1e-5
_FEW = 1e-3  # Of all numbers, such as pixels at the edge of something


@dataclass(frozen=True)
class Verified:
    """What was looked at.

    Attributes:
        units: How many units, of how many that are finished.
        finished: How many of the data set's units are finished.
        faces: How many faces these units have.
        same: Whether every bit was the same; else rounding differs, as between processors.
    """

    units: int
    finished: int
    faces: int
    same: bool

    def __str__(self) -> str:
        bits = "bit for bit" if self.same else "but for rounding"
        return (
            f"{self.faces:,} faces in {self.units:,} of {self.finished:,} finished units were made "
            f"again and are as stored, {bits}"
        )


def verify_faces(
    place: str | PathLike[str],
    units: int = 4,
    *,
    seed: int | None = None,
    storage_options: Mapping[str, Any] | None = None,
    progress: Callable[[str], object] = lambda _: None,
) -> Verified:
    """Make a random sample of a data set again and compare it with what is stored.

    Args:
        place: The data set.
        units: How many units are made again; all where there are fewer.
        seed: Chooses them; another choice each time by default.
        storage_options: What fsspec needs to reach it.
        progress: Told which unit is looked at.

    Raises:
        FormatError: Something stored is not what was written, or not what the recipe says.
        ParameterError: No number of units.
    """
    if not is_whole(units) or units < 1:
        raise ParameterError(f"a sample is one unit or more, found {units!r}")
    order = order_of(place, storage_options)
    with naming_store(order):
        data = DataSet(order, read_only=True)
        entries = data.manifest.entries()
        whole = {unit: len(data.manifest.rows(unit)) for unit in entries}
        finished = sorted(unit for unit, entry in entries.items() if entry[0] == whole[unit])
        if not finished:
            raise FormatError(order.url, "nothing is finished that could be verified")
        random = np.random.default_rng(seed)
        chosen = sorted(random.choice(finished, min(units, len(finished)), replace=False).tolist())
        same, faces = True, 0
        for number, unit in enumerate(chosen, 1):
            progress(f"unit {unit}, {number} of {len(chosen)}")
            same &= _verify_unit(data, unit)
            faces += len(data.manifest.rows(unit))
    return Verified(len(chosen), len(finished), faces, same)


def _verify_unit(data: DataSet, unit: int) -> bool:
    """Whether a unit is the same bit for bit."""
    rows, entry, same = data.manifest.rows(unit), data.manifest.entry(unit), True
    where = f"faces {rows.start:,} to {rows.stop - 1:,}"
    checksums = [] if entry is None else entry[2::2].tolist()
    for name, expected in zip(data.plan.arrays, checksums, strict=True):
        shard = data.manifest.shard(name, unit)
        if zlib.crc32(data.objects.get(shard) or b"") != expected:
            raise FormatError(
                data.order.url,
                f"{where}: what is stored in {shard} is not what was written; remove it and give "
                "the command that made it again",
            )
    start = rows.start
    for block in unit_rows(data, rows):
        for name, made in block.items():
            with naming_damage(data.order, where):
                stored = np.asarray(data.array(name)[start : start + len(made)])
            if not np.array_equal(stored, made):
                same = False
                if name == "weights" or not _close(stored, made):
                    raise FormatError(
                        data.order.url,
                        f"{where}: of {name} the recipe makes other ones than are stored; was it "
                        f"made by version {data.plan.version} of elastomorph, on another kind of "
                        "machine?",
                    )
        start += len(made)
    return same


def _close(stored: NDArray[Any], made: NDArray[Any]) -> bool:
    a, b = stored.astype(np.float64), made.astype(np.float64)
    step = 1.0 if stored.dtype.kind in "iu" else _ROUNDED * np.abs(a).max(initial=1e-30)
    return bool((np.abs(a - b) > step).mean() <= (_FEW if stored.ndim > 3 else 0.0))
