"""The Zarr group of a data set, opened: what was asked for, its arrays, and what makes their rows.

The group's attribute ``elastomorph`` holds what was asked for; the array ``manifest`` is made last,
so that a data set whose beginning was cut short is known by that and begun again. Rigs are kept
packed, and known again by their hash.
"""

from __future__ import annotations

import base64
import hashlib
import io
import json
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, lru_cache
from hashlib import blake2b
from importlib.metadata import version
from typing import Any

import numpy as np

from elastomorph.errors import FormatError, ParameterError
from elastomorph.farm.sampling.columns import Columns
from elastomorph.farm.sampling.sampler import FaceSampler
from elastomorph.farm.storage import manifest as manifests
from elastomorph.farm.storage.contents import Content, Poser, contents_of
from elastomorph.farm.storage.manifest import Manifest
from elastomorph.farm.storage.stores import Objects, Order, naming_damage
from elastomorph.io.atomic import temporary_folder
from elastomorph.io.npz.members import open_npz, pack_arrays
from elastomorph.io.npz.rig import rig_arrays, rig_of_members
from elastomorph.model.mesh import Material, Texture
from elastomorph.rig.build import extent_of
from elastomorph.rig.rig import Rig

_LOOKS = "appearance"
_ROUNDING = 1e-6  # Of D: paths made on another processor may differ by so little


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


def packed(rig: Rig) -> bytes:
    """The bytes of the rig's archive (.npz), and how it looks."""
    arrays, looks = rig_arrays(rig), rig.neutral.appearance
    if looks is not None:
        arrays[_LOOKS] = np.array(
            [
                json.dumps(
                    {n: asdict(replace(m, finish=None)) for n, m in looks.items()}, default=_coded
                )
            ]
        )
    file = io.BytesIO()
    pack_arrays(file, arrays)
    return file.getvalue()


def unpacked(content: bytes) -> Rig:
    """The rig of an archive's bytes."""
    with temporary_folder() as folder:
        path = folder / "rig.npz"
        path.write_bytes(content)
        with open_npz(path) as members:
            rig = rig_of_members(members)
            if _LOOKS in members.names:
                looks = json.loads(members.texts(_LOOKS, 1)[0])
                # A mesh is not changed once others have it; nobody has this one yet.
                vars(rig.neutral).update(appearance={n: _material(m) for n, m in looks.items()})
            return rig


def _coded(value: object) -> str:
    """The bytes of an image as text."""
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    raise TypeError(f"{type(value).__name__} in a material")


def _material(found: dict[str, Any]) -> Material:
    texture = found["texture"]
    if texture is not None:
        lists = {name: tuple(own) for name, own in texture.items() if isinstance(own, list)}
        image = base64.b64decode(texture["image"])
        texture = Texture(**{**texture, **lists, "image": image})
    return Material(**{**found, "colour": tuple(found["colour"]), "texture": texture})


def same_rig(a: Rig, b: Rig) -> bool:
    """Whether two rigs make the same faces but for rounding."""
    if a.sliders != b.sliders or a.neutral.faces != b.neutral.faces:
        return False
    times, near = np.linspace(0, 1, 17), _ROUNDING * (extent_of(a) or 1.0)
    first, second = a.fields.matrix(np.float64), b.fields.matrix(np.float64)
    if first.shape != second.shape or not np.allclose(first, second, rtol=0, atol=near):
        return False
    return all(
        np.allclose(own.factors(times), other.factors(times), rtol=0, atol=_ROUNDING)
        for own, other in zip(a.fields.morphs, b.fields.morphs, strict=True)
    )


FORMAT = 2  # 1 is read and gone on with too: it has no `created` and no checksums in chunks
ATTRIBUTE = "elastomorph"
ROOT = "zarr.json"
REPLACED = "this is not the data set that it was: open it again, or give its command again"
BEGIN_ANEW = "take it from a copy, or begin another data set"


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
    codec: str = "lz4"
    created: str = ""  # Another each time a data set is laid out; none in those of format 1
    version: str = field(default_factory=lambda: version("elastomorph"))
    format: int = FORMAT

    @property
    def checked(self) -> bool:
        """Whether each chunk has a checksum."""
        return self.format > 1


class DataSet:
    """A data set that is there, and what is needed to make its units."""

    def __init__(self, order: Order, *, read_only: bool = False) -> None:
        self.order = order
        self.objects = Objects(order, read_only=read_only)
        self.identity = _identity(self.objects)
        self.group = group_of(order, self.objects)
        self.plan = plan_of(order, self.group)
        with naming_damage(order, manifests.NAME, BEGIN_ANEW):
            whole = manifests.NAME in self.group
        if not whole:
            raise FormatError(
                order.url, "this data set was not begun to the end; give its command again"
            )
        self.faces = self.array("weights").shape[0]
        self.manifest = Manifest(
            self.objects,
            {name: self.array(name).ndim for name in self.plan.arrays},
            self.plan.unit,
            self.faces,
            checked=self.plan.checked,
        )

    def require_in_place(self) -> None:
        """Refuse to go on where another data set has taken the place of this one.

        Raises:
            FormatError: It has, or nothing is there any more.
        """
        if _identity(self.objects) != self.identity:
            raise FormatError(self.order.url, REPLACED)

    def array(self, name: str) -> Any:
        """An array of the group."""
        with naming_damage(self.order, name, BEGIN_ANEW):
            return self.group[name]

    @cached_property
    def rig(self) -> Rig:
        """The rig with which the data set was begun."""
        with naming_damage(self.order, "the rig", BEGIN_ANEW):
            return unpacked(self.array("rig")[:].tobytes())

    @cached_property
    def sampler(self) -> FaceSampler:
        """The recipe at work."""
        with naming_damage(self.order, "its takes", BEGIN_ANEW):
            tables = {name: self.array(f"tables/{name}")[...] for name in self.plan.tables}
        try:
            return FaceSampler.restored(self.rig, self.plan.recipe, tables)
        except ParameterError as error:
            raise FormatError(self.order.url, f"what it keeps is damaged: {error}") from None

    @property
    def columns(self) -> Columns:
        """What the columns of codes are."""
        return self.sampler.columns

    @cached_property
    def poser(self) -> Poser:
        """Makes positions."""
        return Poser(self.rig, self.columns)

    @cached_property
    def contents(self) -> list[Content]:
        """What is stored beside codes."""
        return contents_of(self.poser, self.plan.contents)

    def adopt(self, rig: Rig, sampler: FaceSampler) -> None:
        """Use a rig and a recipe that are the same as those kept, rather than a second copy."""
        vars(self).update(rig=rig, sampler=sampler)

    def prepare(self) -> None:
        """Make once what all units need, before threads ask for it at the same time."""
        for content in self.contents:
            content.prepare()


def opened(order: Order) -> DataSet:
    """Return the data set that is at a place now, for those that make its units.

    Each process keeps it, rig and all. Workers outlive many data sets at one address, so it is
    found again by what identifies it and by how many faces it has, which are read each time.

    Raises:
        FileError: There is none, or it cannot be read.
    """
    objects = Objects(order)
    return _opened(order, _identity(objects), objects.get(f"weights/{ROOT}"))


@lru_cache(maxsize=4)
def _opened(order: Order, identity: str, length: bytes | None) -> DataSet:
    return DataSet(order)


def _identity(objects: Objects) -> str:
    """Return a digest of what a data set was laid out with, which tells it from any other."""
    return blake2b(objects.get(ROOT) or b"", digest_size=16).hexdigest()


def group_of(order: Order, objects: Objects) -> Any:
    """The Zarr group at a place, refused where there is none."""
    import zarr

    if not objects.size(ROOT):
        raise FormatError(order.url, "there is no data set; make one with  elastomorph farm")
    with naming_damage(order, ROOT, BEGIN_ANEW):
        return zarr.open_group(objects.store, mode="r" if objects.store.read_only else "r+")


def plan_of(order: Order, group: Any) -> Plan:
    """What a group was begun for, refused where it is none of ours."""
    found = group.attrs.get(ATTRIBUTE)
    if not isinstance(found, dict):
        raise FormatError(
            order.url, "this is a Zarr group, but no data set of ours; name another output"
        )
    if found.get("format") not in (1, FORMAT):
        raise FormatError(
            order.url,
            f"this data set has format {found.get('format')!r}, expected {FORMAT}; update "
            "elastomorph",
        )
    try:
        return Plan(**found)
    except TypeError as error:
        raise FormatError(order.url, f"its attributes are damaged: {error}") from None
