"""Data sets read: faces, weights and labels as arrays that are read when they are sliced."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError
from elastomorph.farm.columns import Columns
from elastomorph.farm.contents import Vertices
from elastomorph.farm.layout import DataSet
from elastomorph.farm.stores import naming_damage, naming_store, order_of
from elastomorph.rig.rig import Rig

Selection = slice | NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Rows:
    """An array with a row a face that is read or made when it is sliced, as NumPy slices.

    Attributes:
        shape: Its first number is that of the faces.
        dtype: Of what slices give.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    read: Callable[[Selection], NDArray[Any]]

    @property
    def ndim(self) -> int:
        """How many axes."""
        return len(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, index: Any) -> NDArray[Any]:
        first, *others = index if isinstance(index, tuple) else (index,)
        if first is Ellipsis:
            first, others = slice(None), [Ellipsis, *others] if others else []
        if isinstance(first, int | np.integer):
            row = range(len(self))[first]
            found = np.asarray(self.read(slice(row, row + 1))[0])
            return np.asarray(found[tuple(others)]) if others else found
        rows = self._selection(first)
        found = self.read(rows)
        return found[(slice(None), *others)] if others else found

    def __iter__(self) -> Iterator[NDArray[Any]]:
        return (self[row] for row in range(len(self)))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return self[:] if dtype is None else self[:].astype(dtype, copy=False)

    def _selection(self, index: Any) -> Selection:
        if isinstance(index, slice):
            rows = range(len(self))[index]
            if rows.step == 1:
                return slice(rows.start, max(rows.start, rows.stop))
            return np.arange(rows.start, rows.stop, rows.step)
        given = np.asarray(index)
        if given.dtype == bool and given.shape == (len(self),):
            return np.flatnonzero(given)
        if given.ndim != 1 or (given.dtype.kind not in "iu" and given.size):
            raise IndexError(f"faces are taken by a number, a slice or a list, not {index!r}")
        given = given.astype(np.int64)
        if given.size and not (-len(self) <= given.min() and given.max() < len(self)):
            raise IndexError(f"there are {len(self):,} faces, found {given.min()} to {given.max()}")
        return given % max(len(self), 1)


class FaceSet:
    """A data set of faces, open for reading: ``faces[10:20]`` are (10, V, 3) float32 positions.

    Positions are read where they are stored, and made from the recipe where they are not.

    Attributes:
        rig: The rig.
        weights: (N, sliders) float64, the weights of the rig's sliders.
        values: (N, C) float64, all columns; `columns` says what they are.
        codes: (N, C) uint16, as stored.
    """

    def __init__(self, data: DataSet) -> None:
        self.data = data
        self._finished: set[int] = set()

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
        stored = next((own for own in self.data.contents if isinstance(own, Vertices)), None)
        if stored is None:
            return Rows(shape, np.dtype(np.float32), self._made)
        array = self.labels["vertices"]
        return Rows(shape, np.dtype(np.float32), lambda s: stored.encoder.decoded(array.read(s)))

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

    def _made(self, rows: Selection) -> NDArray[np.float32]:
        numbers = np.arange(rows.start, rows.stop) if isinstance(rows, slice) else rows
        left = self.data.poser.coefficients(self.codes.read(rows))
        return self.data.poser.positions(left, numbers)

    def _stored(self, name: str) -> Rows:
        array = self.data.array(name)

        def read(rows: Selection) -> NDArray[Any]:
            self._require_finished(rows)
            with naming_store(self.data.order), naming_damage(self.data.order, name):
                return np.asarray(array[rows] if isinstance(rows, slice) else array.oindex[rows])

        return Rows(array.shape, np.dtype(array.dtype), read)

    def _require_finished(self, rows: Selection) -> None:
        """Refuse faces that are not made yet."""
        manifest, unit = self.data.manifest, self.data.plan.unit
        numbers = np.arange(rows.start, rows.stop) if isinstance(rows, slice) else rows
        units, last = np.divmod(numbers, unit)
        for number in np.unique(units).tolist():
            if number in self._finished:
                continue
            entry = manifest.entry(number)
            there = 0 if entry is None else int(entry[0])
            if there <= last[units == number].max():
                raise FormatError(
                    self.data.order.url,
                    f"the faces {number * unit + there:,} to {manifest.rows(number)[-1]:,} are not "
                    "made yet: give the command that began it again, it goes on",
                )
            if there == len(manifest.rows(number)):
                self._finished.add(number)


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
