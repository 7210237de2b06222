"""Arrays with a row a face that are read or made when they are sliced, with NumPy or with Dask."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MissingExtraError, ParameterError
from elastomorph.farm.storage.contents import IMAGES
from elastomorph.numbers import power_of_two

if TYPE_CHECKING:
    from elastomorph.farm.reading.faces import FaceSet


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
