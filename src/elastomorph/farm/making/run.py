"""Data sets of faces: begun or gone on with, and made to the end.

Data sets begun: laid out, or found to be what was asked for, and made longer.

Everything is compared before anything is written. What is laid out is the same whenever it is done,
and the manifest comes last: a beginning that was cut short is done again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.farm.making.executors import Progress, client_of, make_units
from elastomorph.farm.reading.faces import FaceSet, open_faces
from elastomorph.farm.sampling.recipe import Recipe
from elastomorph.farm.sampling.sampler import FaceSampler
from elastomorph.farm.storage import manifest as manifests
from elastomorph.farm.storage.contents import Content, Label, Poser, contents_of
from elastomorph.farm.storage.layout import (
    ATTRIBUTE,
    ROOT,
    DataSet,
    Plan,
    group_of,
    opened,
    packed,
    plan_of,
    rig_hash,
    same_rig,
)
from elastomorph.farm.storage.manifest import zarr_codecs
from elastomorph.farm.storage.stores import Objects, Order, naming_store, order_of
from elastomorph.farm.storage.wanted import LEAST, Wanted, pictured
from elastomorph.numbers import is_whole, power_of_two
from elastomorph.rig.rig import Rig

if TYPE_CHECKING:
    from distributed import Client


_UNIT_BYTES = 32 * 2**20  # Of the largest array of a unit: a few of them are in memory at a time
_CHUNK_BYTES = 2**20  # Read to get at one face
_MOST_UNIT = 2**16
_WHOLE_CHUNK = 16 * 2**20
_MOST_UNITS = 2**26  # The manifest has a row and an object for each

_KEYS: Any = {"name": "default", "separator": "."}  # A folder an array, not one a shard
_BEGUN = "this data set was begun with {}: give what it was begun with, or another output"
_NAMES = {"default": "name", "separator": "."}


def begin(order: Order, rig: Rig, sampler: FaceSampler, faces: int, wanted: Wanted) -> DataSet:
    """Begin a data set, or go on with one that was begun for the same; nothing is made yet.

    Raises:
        FormatError: What is there was begun for something else, or is no data set.
        ParameterError: Too many units.
    """
    plan, labels = _planned(rig, sampler, wanted)
    if faces > _MOST_UNITS * plan.unit:
        raise ParameterError(
            f"{faces:,} faces in units of {plan.unit:,} are more than {_MOST_UNITS:,} units: ask "
            "for fewer faces, or larger units"
        )
    objects = Objects(order)
    with objects.alone():
        if _is_there(order, objects):
            found = DataSet(order)
            _require_same(found, plan, rig, sampler)
            if wanted.unit not in (None, found.plan.unit):
                raise FormatError(order.url, _BEGUN.format(f"units of {found.plan.unit:,} faces"))
            if faces < found.faces:
                raise FormatError(
                    order.url,
                    f"this data set has {found.faces:,} faces, and {faces:,} were asked for: one "
                    "may grow, but not shrink",
                )
            _lengthen(found, faces)
        else:
            _lay_out(objects, plan, labels, rig, sampler, faces)
    data = opened(order)
    if data.plan.rig == plan.rig and "pictures" not in data.plan.contents:
        data.adopt(rig, sampler)
    return data


def _planned(rig: Rig, sampler: FaceSampler, wanted: Wanted) -> tuple[Plan, dict[str, Label]]:
    columns = sampler.columns
    ranges = [[column.low, column.high] for column in columns]
    weights = Label(
        (len(columns),),
        "uint16",
        {
            "columns": list(columns.names),
            "ranges": ranges,
            "value": "low + code * (high - low) / 65535",
        },
    )
    labels: dict[str, Label] = {"weights": weights}
    chosen = wanted.contents(rig, sampler)
    contents = contents_of(Poser(rig, columns), chosen)
    for content in contents:
        labels |= content.labels
    plan = Plan(
        rig_hash(rig),
        wanted.unit or unit_size(labels, contents),
        sampler.recipe.text(),
        columns.listed(),
        chosen,
        list(labels),
        list(sampler.tables),
        wanted.codec,
    )
    return plan, labels


def unit_size(labels: Mapping[str, Label], contents: Sequence[Content]) -> int:
    """Faces in a unit: a power of two, by what its largest array takes and how long it takes."""
    largest = max(label.bytes for label in labels.values())
    fitting = power_of_two(_UNIT_BYTES // max(largest, 1))
    most = min([_MOST_UNIT, *(content.most for content in contents)])
    return max(LEAST, min(fitting, most))


def _lay_out(
    objects: Objects,
    plan: Plan,
    labels: Mapping[str, Label],
    rig: Rig,
    sampler: FaceSampler,
    faces: int,
) -> None:
    """Make the group and its arrays; those of a beginning that was cut short are replaced."""
    import zarr

    attributes = {ATTRIBUTE: asdict(replace(plan, created=uuid4().hex))}
    group = zarr.create_group(
        objects.store, zarr_format=3, attributes=attributes, overwrite=bool(objects.size(ROOT))
    )
    _store_whole(group, "rig", np.frombuffer(packed(rig), np.uint8))
    _store_whole(group, "neutral", rig.neutral.vertices)
    for name, table in sampler.tables.items():
        _store_whole(group, f"tables/{name}", table)
    for name, label in labels.items():
        _make_array(group, name, label, faces, plan.unit, plan.codec)
    width = 1 + 2 * len(plan.arrays)
    group.create_array(
        manifests.NAME,
        shape=(-(-faces // plan.unit), width),
        chunks=(1, width),
        dtype="<u8",
        compressors=zarr_codecs("none"),
        fill_value=0,
        chunk_key_encoding=_KEYS,
    )


def _lengthen(data: DataSet, faces: int) -> None:
    """Make the arrays longer; its last unit, if it was not a whole one, is then unfinished."""
    lengths = {manifests.NAME: -(-faces // data.plan.unit)}
    lengths |= dict.fromkeys(reversed(data.plan.arrays), faces)  # weights last: they say how many
    for name, length in lengths.items():
        array = data.array(name)
        if array.shape[0] < length:
            array.resize((length, *array.shape[1:]))


def _make_array(group: Any, name: str, label: Label, faces: int, unit: int, codec: str) -> None:
    together = power_of_two(_CHUNK_BYTES // max(label.bytes, 1))
    group.create_array(
        name,
        shape=(faces, *label.shape),
        shards=(unit, *label.shape),
        chunks=(min(unit, together), *label.shape),
        dtype=label.dtype,
        compressors=zarr_codecs(codec),
        fill_value=0,
        attributes=dict(label.attributes),
        chunk_key_encoding=_KEYS,
    )


def _store_whole(group: Any, name: str, values: NDArray[Any]) -> None:
    chunks = (min(len(values), _WHOLE_CHUNK // max(1, values[:1].nbytes)), *values.shape[1:])
    array = group.create_array(
        name,
        shape=values.shape,
        chunks=chunks,
        dtype=values.dtype,
        compressors=zarr_codecs("zstd"),
        chunk_key_encoding=_KEYS,
    )
    array[...] = values


def _is_there(order: Order, objects: Objects) -> bool:
    """Whether a data set of ours is at an output; anything else there is refused."""
    folder = order.folder
    if folder is not None and folder.exists() and not folder.is_dir():
        raise FormatError(order.url, "this is a file; name a folder for the data set")
    if objects.size(ROOT):
        group = group_of(order, objects)
        plan_of(order, group)
        return manifests.NAME in group
    if folder is not None and folder.is_dir():
        others = [own for own in folder.iterdir() if own.suffix != ".partial"]
        if others:
            raise FormatError(
                order.url,
                f"this folder holds something else ({others[0].name}); name one that is empty or "
                "not there",
            )
    return False


def _require_same(there: DataSet, plan: Plan, rig: Rig, sampler: FaceSampler) -> None:
    """Refuse to go on with a data set that was begun for something else."""
    differ = [
        what
        for name, what in (
            ("recipe", "another recipe or seed"),
            ("columns", "other columns"),
            ("contents", "other contents"),
            ("codec", "another codec"),
        )
        if not _alike(getattr(there.plan, name), getattr(plan, name))
    ]
    if there.plan.rig != plan.rig and not same_rig(there.rig, rig):
        differ.insert(0, "another rig")
    if not differ and not _same_tables(there.sampler.tables, sampler.tables):
        differ = ["other takes"]
    if differ:
        raise FormatError(there.order.url, _BEGUN.format(differ[0]))


def _same_tables(a: Mapping[str, NDArray[Any]], b: Mapping[str, NDArray[Any]]) -> bool:
    return a.keys() == b.keys() and all(np.array_equal(a[name], b[name]) for name in a)


def _alike(a: Any, b: Any) -> bool:
    """Whether JSON is the same, its numbers but for rounding."""
    if isinstance(a, dict) and isinstance(b, dict):
        return list(a) == list(b) and all(_alike(a[key], b[key]) for key in a)
    if isinstance(a, list) and isinstance(b, list):
        return len(a) == len(b) and all(map(_alike, a, b))
    if isinstance(a, float) and isinstance(b, float):
        return math.isclose(a, b, rel_tol=1e-9)
    return bool(a == b)


def make_faces(
    rig: Rig,
    output: str | PathLike[str],
    faces: int | None = None,
    *,
    recipe: Recipe | Mapping[str, Any] | str | Path | None = None,
    seed: int | None = None,
    vertices: str | None = None,
    tolerance: float | None = None,
    normals: bool = False,
    landmarks: Mapping[str, int] | str | None = None,
    render: int | None = None,
    codec: str = "lz4",
    unit: int | None = None,
    storage_options: Mapping[str, Any] | None = None,
    scheduler: str | Client = "none",
    progress: Callable[[Progress], object] = lambda _: None,
) -> FaceSet:
    """Make a data set of faces, or go on where it stood.

    It holds recipe, rig and weights; positions are made when they are read, or stored too. Units
    are made on all cores and written whole: whatever ends the process, the same call goes on.

    Args:
        rig: The rig.
        output: A folder, made where it is missing, or an address that fsspec knows.
        faces: How many; more than there are make a data set grow. None: all of a finite recipe.
        recipe: As for `FaceSampler`.
        seed: As for `FaceSampler`.
        vertices: Store positions as ``float32``, ``float16`` or ``int16``.
        tolerance: Largest error of stored positions in units of D. By default that of the type;
            for int16 1e-4, or the least that the rig allows.
        normals: Store (V, 3) float32 normals.
        landmarks: Store (L, 3) float32 positions of vertices, by name; ``clicks``, ``68`` or
            ``mediapipe`` of a rig whose points are known. Default: the recipe's.
        render: Store pictures with labels, so many pixels a side. Default: the recipe's.
        codec: ``lz4``, ``zstd``, which is slower and a quarter smaller, or ``none``.
        unit: Faces made and written together, a power of two. Default: as many as make 32
            MiB of the largest array, fewer with pictures.
        storage_options: What fsspec needs to reach the address.
        scheduler: ``none``, the threads of this process; ``local``, processes of this machine, in
            a script below ``if __name__ == "__main__"``; the address of a Dask scheduler, or a
            ``distributed.Client``.
        progress: Told how far it is, an object that prints as a sentence, after each unit.

    Returns:
        The data set, open for reading.

    Raises:
        FileError: The output cannot be written; what is finished stays.
        FormatError: The output is something else, or a data set begun with other arguments.
        ParameterError: An argument that cannot be meant.
        ClusterError: The scheduler does not answer or is gone, or its workers do not suit.
        MissingExtraError: Zarr or Dask is not installed.
    """
    order = order_of(output, storage_options)
    sampler = FaceSampler(rig, pictured(recipe, render), seed=seed)
    wanted = Wanted(vertices, tolerance, normals, landmarks, codec, unit)
    with naming_store(order), client_of(scheduler) as client:
        work_off(begun(order, rig, sampler, faces, wanted), client, progress)
    return open_faces(order.url, storage_options=storage_options)


def begun(
    order: Order, rig: Rig, sampler: FaceSampler, faces: int | None, wanted: Wanted
) -> DataSet:
    """The data set that is asked for, laid out with what was finished before."""
    count = sampler.count if faces is None else faces
    if count is None:
        raise ParameterError("say how many faces are to be made; this recipe has any number")
    if not is_whole(count) or count < 1:
        raise ParameterError(f"a data set has one face or more, found {faces!r}")
    if sampler.count is not None and count > sampler.count:
        raise ParameterError(
            f"the recipe has {sampler.count:,} faces, and {count:,} were asked for: leave the "
            "number out for all of them"
        )
    data = begin(order, rig, sampler, count, wanted)
    data.objects.sweep(all_of_them=False)
    return data


def work_off(
    data: DataSet,
    client: Client | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
) -> None:
    """Make all units that are not finished."""
    manifest, finished = data.manifest, data.manifest.all_finished()
    # One after another: of all that are to be made a list may be larger than the memory.
    waiting = (unit for unit in range(manifest.units) if unit not in finished)
    state = Progress(data.faces, sum(len(manifest.rows(unit)) for unit in finished))
    progress(state)
    try:
        for made in make_units(data, waiting, client) if len(finished) < manifest.units else ():
            state.add(made)
            progress(state)
    except KeyboardInterrupt:
        raise KeyboardInterrupt(
            f"interrupted after {state.done:,} of {data.faces:,} faces; the same command goes on"
        ) from None
    data.objects.sweep(all_of_them=True)
