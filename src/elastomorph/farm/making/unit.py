"""One unit of a data set: made and written whole, once, by whoever is asked to."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.farm.storage.contents import Faces
from elastomorph.farm.storage.layout import REPLACED, DataSet, opened
from elastomorph.farm.storage.posing import TOGETHER
from elastomorph.farm.storage.shards import Shard, packing
from elastomorph.farm.storage.stores import Order, naming_store

_BLOCK, _BLOCK_BYTES = 4 * TOGETHER, 64 * 2**20
"""Faces in memory at a time beside their codes: so many, or fewer where they are large."""


@dataclass(frozen=True)
class Made:
    """What was done: 0 seconds and bytes where the unit was finished before."""

    unit: int
    faces: int
    seconds: float
    bytes: int


def make_unit(order: Order, identity: str, unit: int) -> Made:
    """Make and write a unit, unless it is finished; the same bits wherever it is done.

    Args:
        order: Where the data set is.
        identity: Of the data set that is meant (`DataSet.identity`).
        unit: Number of the unit.

    Raises:
        FileError: The store cannot be written, or is no data set.
        FormatError: Another data set has taken the place of the one that is meant.
    """
    start = time.perf_counter()
    with naming_store(order):
        data = opened(order)
        if data.identity != identity:
            raise FormatError(order.url, REPLACED)
        rows = data.manifest.rows(unit)
        if data.manifest.finished(unit):
            return Made(unit, len(rows), 0.0, 0)
        shards = unit_shards(data, rows)
        data.require_in_place()  # Units of pictures take a minute
        data.objects.put({data.manifest.shard(n, unit): own for n, own in shards.items()})
        data.require_in_place()
        size = data.manifest.finish(unit, shards)
    return Made(unit, len(rows), time.perf_counter() - start, size)


def unit_shards(data: DataSet, rows: range) -> dict[str, bytes]:
    """The shard of every array for the faces of a unit; empty where it need not be there."""
    pack = packing(data.plan.codec, checked=data.plan.checked)
    arrays = {name: data.array(name) for name in data.plan.arrays}
    shards = {n: Shard(data.plan.unit, own.chunks[0], pack) for n, own in arrays.items()}
    for made in unit_rows(data, rows):
        for name, values in made.items():
            shards[name].add(values)
    return {name: shard.content() for name, shard in shards.items()}


def unit_rows(data: DataSet, rows: range) -> Iterator[dict[str, NDArray[Any]]]:
    """The rows of every array for some faces, a block at a time, so that little is in memory."""
    codes = data.sampler.codes(rows.start, rows.stop)
    if not data.contents:
        yield {"weights": codes}
        return
    size = sum(label.bytes for content in data.contents for label in content.labels.values())
    block = max(1, min(_BLOCK, _BLOCK_BYTES // size))
    for faces in Faces(data.poser, codes, np.arange(rows.start, rows.stop)).blocks(block):
        made: dict[str, NDArray[Any]] = {"weights": faces.codes}
        for content in data.contents:
            made |= content.made(faces)
        yield made
