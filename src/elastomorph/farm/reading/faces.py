"""Data sets read: faces, weights and labels as arrays that are read when they are sliced."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property, lru_cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, ParameterError
from elastomorph.farm.reading.rows import Chunks, Rows, Selection, numbers_of
from elastomorph.farm.sampling.columns import Columns
from elastomorph.farm.storage.contents import Vertices
from elastomorph.farm.storage.layout import REPLACED, DataSet
from elastomorph.farm.storage.stores import Order, naming_damage, naming_store, order_of
from elastomorph.rig.rig import Rig

if TYPE_CHECKING:
    from elastomorph.farm.reading.rows import PictureRows
    from elastomorph.farm.reading.torch_faces import FaceDataset

_OWN = ("vertices", "weights", "values", "codes")
"""Arrays that every data set has, whatever is stored."""


class FaceSet:
    """A data set of faces, open for reading: ``faces[10:20]`` are (10, V, 3) float32 positions.

    Positions are read where they are stored, and made from the recipe where they are not. It can
    be pickled: another process then opens the same data set once.

    Attributes:
        rig: The rig.
        weights: (N, sliders) float64, the weights of the rig's sliders.
        values: (N, C) float64, all columns; `columns` says what they are.
        codes: (N, C) uint16, as stored.
    """

    def __init__(self, data: DataSet) -> None:
        self.data = data
        self._finished: set[tuple[str, int]] = set()

    @property
    def rig(self) -> Rig:
        """The rig of the faces."""
        return self.data.rig

    @property
    def columns(self) -> Columns:
        """What a face is drawn from: the sliders first."""
        return self.data.columns

    @property
    def recipe(self) -> str:
        """The recipe, as TOML."""
        return self.data.plan.recipe

    @cached_property
    def vertices(self) -> Rows:
        """(N, V, 3) float32 positions."""
        shape = (len(self), *self.data.array("neutral").shape)
        chosen = self.data.plan.contents.get("vertices")
        if chosen is None:
            return Rows(shape, np.dtype(np.float32), self._made)
        array, encoder = self.labels["vertices"], Vertices(self.data.poser, chosen).encoder
        return Rows(shape, np.dtype(np.float32), lambda s: encoder.decoded(array.read(s)))

    @cached_property
    def codes(self) -> Rows:
        """(N, C) uint16 codes of the columns."""
        return self.labels["weights"]

    @cached_property
    def values(self) -> Rows:
        """(N, C) float64 values of the columns."""
        return Rows(
            self.codes.shape,
            np.dtype(np.float64),
            lambda s: self.columns.decode(self.codes.read(s)),
        )

    @cached_property
    def weights(self) -> Rows:
        """(N, sliders) float64 weights of the rig's sliders."""
        count = len(self.rig.names)
        return Rows(
            (len(self), count),
            np.dtype(np.float64),
            lambda s: np.ascontiguousarray(self.values.read(s)[:, :count]),
        )

    @cached_property
    def labels(self) -> Mapping[str, Rows]:
        """All that is stored of each face, as it is stored, by name."""
        return {name: self._stored(name) for name in self.data.plan.arrays}

    def array(self, name: str) -> Rows:
        """``vertices``, ``weights``, ``values``, ``codes``, or a name in `labels`.

        Raises:
            ParameterError: There is no such array.
        """
        there = dict.fromkeys((*_OWN, *self.labels))
        if not isinstance(name, str) or name not in there:
            raise ParameterError(f"there is no array {name!r}; there are {', '.join(there)}")
        found: Rows = getattr(self, name) if name in _OWN else self.labels[name]
        return found

    def as_dask(self, name: str = "vertices") -> Any:
        """An array as a Dask array, whose chunks are units or parts of them, of 32 MB at most.

        The graph holds where the data set is, not what it holds; each process opens it once.

        Raises:
            ParameterError: There is no such array.
            MissingExtraError: Dask is not installed.
        """
        from elastomorph.farm.reading.rows import lazy_array

        return lazy_array(self, name)

    def as_images(self) -> PictureRows:
        """The pictures with all that is stored beside them, a dict for each face.

        Raises:
            ParameterError: The data set holds no pictures.
        """
        from elastomorph.farm.reading.rows import PictureRows

        return PictureRows(self)

    def export(self, path: str | Path, to: str) -> None:
        """Write pictures and labels for training code; arguments are those of `export_faces`."""
        from elastomorph.farm.reading.export import export_faces

        export_faces(self, path, to)

    def as_torch(self, *names: str) -> FaceDataset:
        """Arrays as a PyTorch ``Dataset`` of dicts of tensors; its ``batches`` load fast.

        Args:
            names: Of arrays, as `array` takes them; ``vertices`` and ``weights`` by default.

        Raises:
            ParameterError: There is no such array.
            MissingExtraError: PyTorch is not installed.
        """
        from elastomorph.farm.reading.torch_faces import FaceDataset

        return FaceDataset(self, names or ("vertices", "weights"))

    @property
    def shape(self) -> tuple[int, ...]:
        """(N, V, 3)."""
        return self.vertices.shape

    @property
    def dtype(self) -> np.dtype[Any]:
        """float32."""
        return self.vertices.dtype

    @property
    def ndim(self) -> int:
        """3."""
        return 3

    def __len__(self) -> int:
        return int(self.data.faces)

    def __getitem__(self, index: Any) -> NDArray[np.float32]:
        return self.vertices[index]

    def __iter__(self) -> Iterator[NDArray[np.float32]]:
        return iter(self.vertices)

    def __repr__(self) -> str:
        stored = ", ".join(self.data.plan.arrays)
        return f"FaceSet({len(self):,} faces of {self.shape[1]:,} vertices; stored: {stored})"

    def __reduce__(self) -> tuple[Any, ...]:
        return _shared, (self.data.order, self._told())

    def _told(self) -> str:
        """What tells the data set from others that were or will be at its place."""
        return f"{len(self)} {self.data.identity}"

    def _made(self, rows: Selection) -> NDArray[np.float32]:
        numbers = numbers_of(rows)
        left = self.data.poser.coefficients(self.codes.read(rows))
        return self.data.poser.positions(left, numbers)

    def _stored(self, name: str) -> Rows:
        array = self.data.array(name)
        chunks = Chunks(array, self.data.require_in_place)

        def read(rows: Selection) -> NDArray[Any]:
            with naming_damage(self.data.order, name):
                keep = self._require_finished(name, rows)
                return chunks.read(rows, keep=keep)

        return Rows(array.shape, np.dtype(array.dtype), read, dict(array.attrs))

    def _require_finished(self, name: str, rows: Selection) -> bool:
        """Refuse faces that are not made yet, or lost; whether all of their units are finished."""
        manifest, unit = self.data.manifest, self.data.plan.unit
        numbers = numbers_of(rows)
        units, last = np.divmod(numbers, unit)
        asked = np.unique(units).tolist()
        for number in asked:
            if (name, number) in self._finished:
                continue
            there = manifest.there(name, number)
            if there is None:
                raise FormatError(
                    self.data.order.url,
                    f"{manifest.shard(name, number)} is not as large as it was written: give the "
                    "command that made it again, it makes that again",
                )
            if there <= last[units == number].max():
                raise FormatError(
                    self.data.order.url,
                    f"the faces {number * unit + there:,} to {manifest.rows(number)[-1]:,} are not "
                    "made yet: give the command that began it again, it goes on",
                )
            if there == len(manifest.rows(number)):
                self._finished.add((name, number))
        return self._finished.issuperset((name, number) for number in asked)


def open_faces(
    path: str | PathLike[str], *, storage_options: Mapping[str, Any] | None = None
) -> FaceSet:
    """Open a data set of faces.

    Args:
        path: Its folder, or an address that fsspec knows.
        storage_options: What fsspec needs to reach it.

    Raises:
        FileError: It is no data set, or cannot be read.
        MissingExtraError: Zarr is not installed.
    """
    order = order_of(path, storage_options)
    with naming_store(order):
        return FaceSet(DataSet(order, read_only=True))


@lru_cache(maxsize=4)
def _shared(order: Order, told: str) -> FaceSet:
    """The data set that was pickled, opened once by each process."""
    faces = open_faces(order.url, storage_options=order.storage_options)
    if faces._told() != told:
        raise FormatError(order.url, REPLACED)
    return faces
