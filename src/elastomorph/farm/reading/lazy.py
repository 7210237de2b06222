"""Arrays of a data set as Dask arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import MissingExtraError
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
