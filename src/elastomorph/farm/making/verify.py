"""A data set looked at again: all checksums, and some units made anew and compared."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.blas_threads import usable_cores
from elastomorph.errors import FormatError, ParameterError
from elastomorph.farm.making.executors import unit_rows
from elastomorph.farm.storage.contents import Faces
from elastomorph.farm.storage.layout import BEGIN_ANEW, DataSet
from elastomorph.farm.storage.stores import naming_damage, naming_store, order_of
from elastomorph.numbers import is_whole

# Another processor rounds sums otherwise: codes by a step, numbers by this part of the largest.
_ROUNDED = 1e-5
_NAMED = 5  # Files in a message
_FEW = 1e-3  # Of all numbers, such as pixels at the edge of something


@dataclass(frozen=True)
class Verified:
    """What was looked at.

    Attributes:
        units: How many units were made again.
        finished: How many of the data set's units are finished; the checksums of all are right.
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
            f"all checksums of {self.finished:,} finished units are right; {self.faces:,} faces in "
            f"{self.units:,} of them were made again and are as stored, {bits}"
        )


def verify_faces(
    place: str | PathLike[str],
    units: int = 4,
    *,
    seed: int | None = None,
    storage_options: Mapping[str, Any] | None = None,
    progress: Callable[[str], object] = lambda _: None,
) -> Verified:
    """Check all that is stored by its checksums, and make a random sample of it again.

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
        _require_whole(data, {unit: entries[unit] for unit in finished}, progress)
        random = np.random.default_rng(seed)
        chosen = sorted(random.choice(finished, min(units, len(finished)), replace=False).tolist())
        same, faces = True, 0
        for number, unit in enumerate(chosen, 1):
            progress(f"making unit {unit} again, {number} of {len(chosen)}")
            same &= _verify_unit(data, unit)
            faces += len(data.manifest.rows(unit))
    return Verified(len(chosen), len(finished), faces, same)


def _require_whole(
    data: DataSet, entries: Mapping[int, NDArray[np.uint64]], progress: Callable[[str], object]
) -> None:
    """Refuse a data set of which anything has changed since it was written."""
    _ = data.sampler  # Reads rig and takes
    with naming_damage(data.order, "neutral", BEGIN_ANEW):
        data.array("neutral")[...]
    arrays = data.plan.arrays

    def damaged(unit: int) -> list[str]:
        shards = [data.manifest.shard(name, unit) for name in arrays]
        found = map(data.objects.get, shards)  # One at a time is in memory
        sums = [zlib.crc32(content or b"") for content in found]
        return [s for s, a, b in zip(shards, sums, entries[unit][2::2], strict=True) if a != b]

    wrong: list[str] = []
    with ThreadPoolExecutor(usable_cores()) as pool:
        for number, found in enumerate(pool.map(damaged, entries), 1):
            progress(f"checksums of {number:,} of {len(entries):,} units")
            wrong += found
    if wrong:
        more = f" and {len(wrong) - _NAMED:,} more" if len(wrong) > _NAMED else ""
        raise FormatError(
            data.order.url,
            f"{', '.join(wrong[:_NAMED])}{more}: not what was written; remove them and give the "
            "command that made it again",
        )


def _verify_unit(data: DataSet, unit: int) -> bool:
    """Whether a unit is the same bit for bit."""
    rows, same = data.manifest.rows(unit), True
    where = f"faces {rows.start:,} to {rows.stop - 1:,}"
    start = rows.start
    for block in unit_rows(data, rows):
        for name, made in block.items():
            with naming_damage(data.order, where):
                stored = np.asarray(data.array(name)[start : start + len(made)])
            if not np.array_equal(stored, made):
                same = False
                numbers = np.arange(start, start + len(made))
                faces = Faces(data.poser, block["weights"], numbers)
                rounding = [own.rounding(faces) for own in data.contents if name in own.labels]
                if name == "weights" or not _close(stored, made, *rounding):
                    raise FormatError(
                        data.order.url,
                        f"{where}: of {name} the recipe makes other ones than are stored; was it "
                        f"made by version {data.plan.version} of elastomorph, on another kind of "
                        "machine?",
                    )
        start += len(made)
    return same


def _close(stored: NDArray[Any], made: NDArray[Any], rounding: float | NDArray[Any]) -> bool:
    a, b, step = stored.astype(np.float64), made.astype(np.float64), np.asarray(1.0)
    if stored.dtype.kind == "f":
        spacing = np.spacing(np.abs(stored)).astype(np.float64)  # That of float16 is coarse
        step = _ROUNDED * np.abs(a).max(initial=1e-30) + spacing + rounding
    same = np.isclose(a, b, rtol=0, atol=step, equal_nan=True)
    return bool((~same).mean() <= (_FEW if stored.ndim > 3 else 0.0))
