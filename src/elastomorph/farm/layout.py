"""The Zarr group of a data set: begun, opened, refused.

The group's attribute ``elastomorph`` holds what was asked for; the array ``manifest`` is made last,
so that a data set whose beginning was cut short is known from it and begun again.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property, lru_cache
from importlib.metadata import version
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.farm import manifest as manifests
from elastomorph.farm.columns import Columns
from elastomorph.farm.contents import Content, Label, contents_of
from elastomorph.farm.manifest import Manifest
from elastomorph.farm.posing import Poser
from elastomorph.farm.sampler import FaceSampler
from elastomorph.farm.stores import Objects, Order
from elastomorph.io.npz.members import open_npz, pack_arrays
from elastomorph.io.npz.rig import rig_arrays, rig_of_members
from elastomorph.io.temporaries import temporary_folder
from elastomorph.rig.rig import Rig

FORMAT = 1
_ATTRIBUTE = "elastomorph"

_UNIT_BYTES = 32 * 2**20  # Of the largest array of a unit: a few of them are in memory at a time
_CHUNK_BYTES = 2**20  # Read to get at one face
_MOST_UNIT, _LEAST_UNIT = 2**16, 32
_RIG_CHUNK = 16 * 2**20


@dataclass(frozen=True)
class Plan:
    """What was asked for, the attribute of the group."""

    rig: str  # Hash of what matters of the rig
    unit: int
    recipe: str  # TOML
    columns: list[list[Any]]  # Name, low and high of each
    contents: dict[str, Any]  # What was chosen of each content
    arrays: list[str]  # In the order of the manifest
    tables: list[str] = field(default_factory=list)
    version: str = field(default_factory=lambda: version("elastomorph"))
    format: int = FORMAT


class DataSet:
    """A data set that is there, and what is needed to make its units."""

    def __init__(self, order: Order, *, read_only: bool = False) -> None:
        self.order = order
        self.objects = Objects(order, read_only=read_only)
        self.group = _group(order, self.objects)
        self.plan = _plan(order, self.group)
        if manifests.NAME not in self.group:
            raise FormatError(
                order.url, "this data set was not begun to the end; give its command again"
            )
        self.faces = self.array("weights").shape[0]
        self.manifest = Manifest(
            self.objects,
            self.array(manifests.NAME),
            {name: self.array(name).ndim for name in self.plan.arrays},
            self.plan.unit,
            self.faces,
        )

    def array(self, name: str) -> Any:
        """An array of the group."""
        return self.group[name]

    @cached_property
    def rig(self) -> Rig:
        """The rig with which the data set was begun."""
        return _unpacked(self.array("rig")[:].tobytes())

    @cached_property
    def sampler(self) -> FaceSampler:
        """The recipe at work."""
        tables = {name: self.array(f"tables/{name}")[...] for name in self.plan.tables}
        return FaceSampler.restored(self.rig, self.plan.recipe, tables)

    @property
    def columns(self) -> Columns:
        """What the columns of codes are."""
        return self.sampler.columns

    @cached_property
    def poser(self) -> Poser:
        """Makes positions."""
        return poser_of(self.rig, self.sampler)

    @cached_property
    def contents(self) -> list[Content]:
        """What is stored beside codes."""
        return contents_of(self.poser, self.plan.contents)

    def prepare(self) -> None:
        """Make once what all units need, before threads ask for it at the same time."""
        for content in self.contents:
            content.prepare()


@lru_cache(maxsize=4)
def opened(order: Order) -> DataSet:
    """A data set for those that make its units, kept by each process.

    Raises:
        FileError: There is none, or it cannot be read.
    """
    return DataSet(order)


def poser_of(rig: Rig, sampler: FaceSampler) -> Poser:
    """What makes the faces of a sampler."""
    return Poser(rig, sampler.columns, bool(getattr(sampler.recipe, "normalize", False)))


def begin(
    order: Order, rig: Rig, sampler: FaceSampler, faces: int, chosen: Mapping[str, Any]
) -> DataSet:
    """Begin a data set, or go on with one that was begun for the same; nothing is made yet.

    Raises:
        FormatError: What is there was begun for something else, or is no data set.
    """
    plan, labels = _planned(rig, sampler, chosen)
    objects = Objects(order)
    there = _already(order, objects)
    if there is not None:
        _require_same(order, there, plan, faces)
        plan = there
    _lay_out(objects, plan, labels, rig, sampler, faces)
    opened.cache_clear()
    return opened(order)


def _planned(
    rig: Rig, sampler: FaceSampler, chosen: Mapping[str, Any]
) -> tuple[Plan, dict[str, Label]]:
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
    for content in contents_of(poser_of(rig, sampler), chosen):
        labels |= content.labels
    largest = max(_bytes_of(label) for label in labels.values())
    unit = 2 ** int(np.log2(max(1, _UNIT_BYTES // max(largest, 1))))
    plan = Plan(
        rig_hash(rig),
        int(np.clip(unit, _LEAST_UNIT, _MOST_UNIT)),
        sampler.recipe.text(),
        columns.listed(),
        dict(chosen),
        list(labels),
        list(sampler.tables),
    )
    return plan, labels


def _lay_out(
    objects: Objects,
    plan: Plan,
    labels: Mapping[str, Label],
    rig: Rig,
    sampler: FaceSampler,
    faces: int,
) -> None:
    """Make the group and its arrays, or make them longer for more faces."""
    import zarr

    group = zarr.open_group(objects.store, mode="a", zarr_format=3)
    if _ATTRIBUTE not in group.attrs:
        group.attrs[_ATTRIBUTE] = asdict(plan)
    units = -(-faces // plan.unit)
    if manifests.NAME not in group:
        packed = np.frombuffer(_packed(rig), np.uint8)
        _store_whole(group, "rig", packed)
        _store_whole(group, "neutral", rig.neutral.vertices)
        for name, table in sampler.tables.items():
            _store_whole(group, f"tables/{name}", table)
        for name, label in labels.items():
            _make_array(group, name, label, faces, plan.unit)
        width = 1 + 2 * len(plan.arrays)
        group.create_array(
            manifests.NAME,
            shape=(units, width),
            chunks=(1, width),
            dtype="<u8",
            compressors=None,
            fill_value=0,
            chunk_key_encoding={"name": "default", "separator": "."},
        )
        return
    for name in (manifests.NAME, *reversed(plan.arrays)):  # weights last: they say how many
        array: Any = group[name]
        length = units if name == manifests.NAME else faces
        if array.shape[0] < length:
            array.resize((length, *array.shape[1:]))


def _make_array(group: Any, name: str, label: Label, faces: int, unit: int) -> None:
    from zarr.codecs import BloscCodec

    together = 2 ** int(np.log2(max(1, _CHUNK_BYTES // max(_bytes_of(label), 1))))
    group.create_array(
        name,
        shape=(faces, *label.shape),
        shards=(unit, *label.shape),
        chunks=(min(unit, together), *label.shape),
        dtype=label.dtype,
        compressors=BloscCodec(cname="lz4", clevel=5, shuffle="shuffle"),
        fill_value=0,
        attributes=dict(label.attributes),
        chunk_key_encoding={"name": "default", "separator": "."},
        overwrite=True,
    )


def _store_whole(group: Any, name: str, values: NDArray[Any]) -> None:
    chunks = (min(len(values), _RIG_CHUNK // max(1, values[:1].nbytes)), *values.shape[1:])
    array = group.create_array(
        name, shape=values.shape, chunks=chunks, dtype=values.dtype, overwrite=True
    )
    array[...] = values


def _bytes_of(label: Label) -> int:
    return int(np.prod(label.shape)) * np.dtype(label.dtype).itemsize


def _group(order: Order, objects: Objects) -> Any:
    import zarr

    if not objects.size("zarr.json"):
        raise FormatError(order.url, "there is no data set; make one with  elastomorph farm")
    return zarr.open_group(objects.store, mode="r" if objects.store.read_only else "r+")


def _plan(order: Order, group: Any) -> Plan:
    found = group.attrs.get(_ATTRIBUTE)
    if not isinstance(found, dict):
        raise FormatError(
            order.url, "this is a Zarr group, but no data set of ours; name another output"
        )
    if found.get("format") != FORMAT:
        raise FormatError(
            order.url,
            f"this data set has format {found.get('format')!r}, expected {FORMAT}; update "
            "elastomorph",
        )
    try:
        return Plan(**found)
    except TypeError as error:
        raise FormatError(order.url, f"its attributes are damaged: {error}") from None


def _already(order: Order, objects: Objects) -> Plan | None:
    """The plan of what is at an output, None where there is nothing."""
    folder = order.folder
    if folder is not None and folder.exists() and not folder.is_dir():
        raise FormatError(order.url, "this is a file; name a folder for the data set")
    if objects.size("zarr.json"):
        return _plan(order, _group(order, objects))
    if folder is not None and folder.is_dir() and any(folder.iterdir()):
        raise FormatError(
            order.url, "this folder holds something else; name one that is empty or not there"
        )
    return None


def _require_same(order: Order, there: Plan, plan: Plan, faces: int) -> None:
    """Refuse to go on with a data set that was begun for something else."""
    differ = {
        "rig": "another rig",
        "recipe": "another recipe or seed",
        "columns": "other columns",
        "contents": "other contents",
    }
    for name, what in differ.items():
        if getattr(there, name) != getattr(plan, name):
            raise FormatError(
                order.url,
                f"this data set was begun with {what}: give what it was begun with, or another "
                "output",
            )


def rig_hash(rig: Rig) -> str:
    """A number that tells rigs apart which make different faces."""
    arrays = rig_arrays(rig)
    matter = ("neutral", "face_", "morph_names", "bend_counts", "field_", "curve", "corrective_")
    own = hashlib.blake2b(digest_size=16)
    for name, array in arrays.items():
        if name.startswith(matter):
            own.update(f"{name} {array.shape} {array.dtype.str}".encode())
            own.update(np.ascontiguousarray(array).tobytes())
    return own.hexdigest()


def _packed(rig: Rig) -> bytes:
    """The bytes of the rig's archive (.npz)."""
    file = io.BytesIO()
    pack_arrays(file, rig_arrays(rig))
    return file.getvalue()


def _unpacked(content: bytes) -> Rig:
    with temporary_folder() as folder:
        path = folder / "rig.npz"
        path.write_bytes(content)
        with open_npz(path) as members:
            return rig_of_members(members)
