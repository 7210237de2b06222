"""One unit of a data set: made and written whole, once, by whoever is asked to."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from elastomorph.farm.contents import Faces
from elastomorph.farm.layout import DataSet, opened
from elastomorph.farm.manifest import checksum
from elastomorph.farm.stores import Order, naming_store


@dataclass(frozen=True)
class Made:
    """What was done: 0 seconds and bytes where the unit was finished before."""

    unit: int
    faces: int
    seconds: float
    bytes: int


def make_unit(order: Order, unit: int) -> Made:
    """Make and write a unit, unless it is finished; the same bits wherever it is done.

    Raises:
        FileError: The store cannot be written, or is no data set.
    """
    start = time.perf_counter()
    with naming_store(order):
        data = opened(order)
        rows = data.manifest.rows(unit)
        if data.manifest.finished(unit):
            return Made(unit, len(rows), 0.0, 0)
        made = unit_rows(data, rows)
        # What a killed writer or a fault left would be read first, to be written over in part.
        data.objects.remove(data.manifest.shard(name, unit) for name in made)
        for name, values in made.items():
            data.array(name)[rows.start : rows.stop] = values
        size = data.manifest.finish(unit, {name: checksum(own) for name, own in made.items()})
    return Made(unit, len(rows), time.perf_counter() - start, size)


def unit_rows(data: DataSet, rows: range) -> dict[str, np.ndarray]:
    """The rows of every array of the data set for some faces."""
    codes = data.sampler.codes(rows.start, rows.stop)
    faces = Faces(data.poser, codes, np.arange(rows.start, rows.stop))
    made = {"weights": codes}
    for content in data.contents:
        made |= content.made(faces)
    return made


def pending(order: Order) -> list[int]:
    """The units that are not finished, the sizes of their shards looked at."""
    with naming_store(order):
        return opened(order).manifest.pending()
