"""Data sets read: faces, weights and labels as arrays that are read when they are sliced.

Arrays with a row a face that are read or made when they are sliced, with NumPy or with Dask.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import FormatError, MissingExtraError, ParameterError
from elastomorph.farm.sampling.columns import Columns
from elastomorph.farm.storage.contents import IMAGES, Vertices
from elastomorph.farm.storage.layout import REPLACED, DataSet
from elastomorph.farm.storage.stores import Order, naming_damage, naming_store, order_of
from elastomorph.numbers import power_of_two
from elastomorph.rig.rig import Rig

if TYPE_CHECKING:
    from elastomorph.farm.reading.torch_faces import FaceDataset


_CHUNK_BYTES = 32 * 2**20


@dataclass(frozen=True, eq=False)
class LazyRows:
    """An array of a data set that is pickled as the place where it is."""

    faces: FaceSet
    name: str
    shape: tuple[int, ...]
    dtype: np.dtype[Any]

    @property
    def ndim(self) -> int:
        """How many axes."""
        return len(self.shape)

    def __getitem__(self, index: Any) -> NDArray[Any]:
        return self.faces.array(self.name)[index]


def lazy_array(faces: FaceSet, name: str) -> Any:
    """See `FaceSet.as_dask`."""
    try:
        from dask.array import from_array
        from dask.base import tokenize
    except ImportError:
        raise MissingExtraError("dask", "farm") from None
    rows = faces.array(name)
    row_bytes = int(np.prod(rows.shape[1:])) * rows.dtype.itemsize
    fitting = power_of_two(_CHUNK_BYTES // max(1, row_bytes))
    return from_array(  # type: ignore[no-untyped-call]
        LazyRows(faces, name, rows.shape, rows.dtype),
        chunks=(min(faces.data.plan.unit, fitting), *rows.shape[1:]),
        name=f"{name}-{tokenize(faces.__reduce__()[1][1], faces.data.order.key, name)}",
        asarray=False,
        lock=False,
        meta=np.empty((0,) * len(rows.shape), rows.dtype),
    )


def pictured(faces: FaceSet) -> dict[str, Rows]:
    """The arrays of the pictures that are stored, by their names without the folder."""
    return {
        name.removeprefix(IMAGES): rows
        for name, rows in faces.labels.items()
        if name.startswith(IMAGES)
    }


class PictureRows:
    """``pictures[7]`` is a dict of what is stored of face 7, ``pictures[10:20]`` of ten of them.

    Keys are ``weights`` ((J,) float64 of the rig's sliders) and the arrays of the pictures without
    their folder, as they are stored: ``colour`` ((H, W, 3) uint8 sRGB), ``depth``, ``normals``,
    ``parts``, ``landmarks``, ``camera``, ``head``, ``intrinsics``. What is asked for by several
    numbers has one more axis in front.

    Attributes:
        arrays: The same by name, each to be sliced by itself; `Rows.attributes` say what they mean.
    """

    def __init__(self, faces: FaceSet) -> None:
        found = pictured(faces)
        if not found:
            raise ParameterError(
                f"{faces.data.order.url} holds no pictures; data sets made with  --render 256  do"
            )
        self.arrays: Mapping[str, Rows] = found | {"weights": faces.weights}

    def __len__(self) -> int:
        return len(self.arrays["weights"])

    def __getitem__(self, index: Any) -> dict[str, NDArray[Any]]:
        return {name: rows[index] for name, rows in self.arrays.items()}

    def __iter__(self) -> Iterator[dict[str, NDArray[Any]]]:
        return (self[number] for number in range(len(self)))


Selection = slice | NDArray[np.int64]

_KEPT_BYTES = 64 * 2**20  # Of one array, decoded


@dataclass(frozen=True, eq=False)
class Rows:
    """An array with a row a face that is read or made when it is sliced, as NumPy slices.

    Attributes:
        shape: Its first number is that of the faces.
        dtype: Of what slices give.
        attributes: What is stored with it, such as ``names`` of landmarks.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    read: Callable[[Selection], NDArray[Any]]
    attributes: Mapping[str, Any] = field(default_factory=dict)

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
            if not -len(self) <= first < len(self):
                raise IndexError(f"there are {len(self):,} faces, found {first}")
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


def numbers_of(rows: Selection) -> NDArray[np.int64]:
    """(S,) the numbers of selected rows."""
    return np.arange(rows.start, rows.stop) if isinstance(rows, slice) else rows


class Chunks:
    """A Zarr array whose chunks that were read last are kept decoded.

    A chunk holds a megabyte: thousands of rows of weights. Reading few rows, or rows in random
    order, would decode the same chunks again and again.

    Args:
        array: The array.
        require_in_place: Called before chunks are read: raises where the array is another by now.
    """

    def __init__(self, array: Any, require_in_place: Callable[[], object]) -> None:
        self._array, self._require_in_place = array, require_in_place
        self.rows = int(array.chunks[0])
        row = int(np.prod(array.shape[1:])) * array.dtype.itemsize
        self._most = max(1, _KEPT_BYTES // max(1, self.rows * row))
        self._chunk = lru_cache(maxsize=self._most)(self._decoded)

    def read(self, rows: Selection, *, keep: bool) -> NDArray[Any]:
        """(S, …) some rows; kept only where what is stored does not change any more."""
        if isinstance(rows, slice):
            first, last = rows.start // self.rows, (rows.stop - 1) // self.rows
            if not keep or not rows.stop > rows.start or last > first + 1:
                return self._stored(rows)
            cuts = range(first * self.rows, rows.stop, self.rows)
            parts = [
                self._chunk(a // self.rows)[max(rows.start - a, 0) : rows.stop - a] for a in cuts
            ]
            return np.concatenate(parts)  # A copy also of one: what is kept is nobody's to change
        chunks, which = np.unique(rows // self.rows, return_inverse=True)
        if not keep or len(chunks) > self._most:
            return self._stored(rows)
        found = np.empty((len(rows), *self._array.shape[1:]), self._array.dtype)
        for number, chunk in enumerate(chunks.tolist()):
            of_chunk = which == number
            found[of_chunk] = self._chunk(chunk)[rows[of_chunk] - chunk * self.rows]
        return found

    def _decoded(self, chunk: int) -> NDArray[Any]:
        return self._stored(slice(chunk * self.rows, (chunk + 1) * self.rows))

    def _stored(self, rows: Selection) -> NDArray[Any]:
        self._require_in_place()
        return np.asarray(self._array.oindex[rows])


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
        return lazy_array(self, name)

    def as_images(self) -> PictureRows:
        """The pictures with all that is stored beside them, a dict for each face.

        Raises:
            ParameterError: The data set holds no pictures.
        """
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
