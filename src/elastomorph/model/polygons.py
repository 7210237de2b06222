"""Polygons of any size, stored flat so that a million of them cost two arrays."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import MeshError


class Polygons(Sequence[NDArray[np.int32]]):
    """An immutable list of polygons, each a list of vertex indices.

    Reads like a list (``polygons[3]`` is the fourth polygon as an (n,) int32 array) and computes
    like two arrays.

    Attributes:
        indices: (C,) int32, the vertex indices of all polygons one after another ("corners").
        offsets: (F + 1,) int64, where each polygon starts in ``indices``.
    """

    __slots__ = ("__dict__", "indices", "offsets")

    def __init__(self, indices: ArrayLike, offsets: ArrayLike) -> None:
        self.indices = np.array(indices, dtype=np.int32)
        self.offsets = np.array(offsets, dtype=np.int64)
        if (
            self.indices.ndim != 1
            or self.offsets.ndim != 1
            or self.offsets.size == 0
            or self.offsets[0] != 0
            or self.offsets[-1] != self.indices.size
        ):
            raise MeshError(
                "polygon offsets must start at 0, end at the number of corners "
                f"({self.indices.size}) and be one more than the polygons"
            )
        sizes = np.diff(self.offsets)
        if sizes.size and sizes.min() < 3:
            face = int(np.argmin(sizes >= 3))
            raise MeshError(
                f"polygon {face} has {sizes[face]} vertices; a polygon needs at least 3"
            )
        self.indices.flags.writeable = False
        self.offsets.flags.writeable = False

    @classmethod
    def of(cls, faces: Polygons | ArrayLike | Sequence[Sequence[int]]) -> Polygons:
        """Polygons from a list of index lists, or from an (F, n) integer array.

        Raises:
            MeshError: A polygon has fewer than three vertices, or an index is not a whole number.
        """
        if isinstance(faces, Polygons):
            return faces
        if isinstance(faces, np.ndarray) and faces.ndim == 2 and faces.shape[1] > 0:
            flat: NDArray[Any] = faces.reshape(-1)
            sizes = np.full(len(faces), faces.shape[1])
        else:
            try:
                rows: Sequence[Sequence[int]] = list(faces)  # type: ignore[arg-type]
                sizes = np.fromiter((len(row) for row in rows), dtype=np.int64, count=len(rows))
                flat = np.array(list(chain.from_iterable(rows)))
            except (TypeError, ValueError):
                raise MeshError(
                    "polygons must be lists of vertex indices, such as [[0, 1, 2, 3]], found "
                    f"{type(faces).__name__}"
                ) from None
        if flat.size and not np.issubdtype(flat.dtype, np.integer):
            raise MeshError(f"polygon indices must be whole numbers, found {flat.dtype}")
        if flat.size and (flat.max() > np.iinfo(np.int32).max or flat.min() < 0):
            raise MeshError("polygon indices must lie between 0 and the number of vertices")
        return cls(flat.astype(np.int32), np.concatenate([[0], np.cumsum(sizes)]))

    @cached_property
    def sizes(self) -> NDArray[np.int64]:
        """(F,) number of vertices of each polygon."""
        return np.diff(self.offsets)

    @cached_property
    def corner_faces(self) -> NDArray[np.int32]:
        """(C,) polygon that each corner belongs to."""
        return np.repeat(np.arange(len(self), dtype=np.int32), self.sizes)

    @cached_property
    def next_corners(self) -> NDArray[np.int64]:
        """(C,) for each corner, the following corner of the same polygon."""
        following = np.arange(1, self.indices.size + 1, dtype=np.int64)
        following[self.offsets[1:] - 1] = self.offsets[:-1]
        return following

    def triangles(self) -> NDArray[np.int32]:
        """(T, 3) int32: every polygon split into a fan from its first vertex."""
        return self.indices[self.triangle_corners()]

    def triangle_corners(self) -> NDArray[np.int64]:
        """(T, 3) which corners of the polygons those of `triangles` are."""
        sizes = self.sizes
        first = np.repeat(self.offsets[:-1], sizes - 2)
        step = np.arange(first.size) - np.repeat(np.cumsum(sizes - 2) - (sizes - 2), sizes - 2)
        return np.stack([first, first + step + 1, first + step + 2], axis=1)

    def __len__(self) -> int:
        return int(self.offsets.size - 1)

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        face = range(len(self))[index]
        return self.indices[self.offsets[face] : self.offsets[face + 1]]

    def __iter__(self) -> Iterator[NDArray[np.int32]]:
        return iter(np.split(self.indices, self.offsets[1:-1])) if len(self) else iter(())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Polygons):
            return NotImplemented
        return self is other or (
            np.array_equal(self.offsets, other.offsets)
            and np.array_equal(self.indices, other.indices)
        )

    def __hash__(self) -> int:
        return hash((self.indices.tobytes(), self.offsets.tobytes()))

    def __repr__(self) -> str:
        return f"Polygons({len(self)} polygons, {self.indices.size} corners)"


def polygon_normals(vertices: NDArray[np.float64], faces: Polygons) -> NDArray[np.float64]:
    """(F, 3) area-weighted normals: n = ½ Σ_c p_c × p_{c+1} over the corners c (Newell)."""
    if not len(faces):
        return np.zeros((0, 3))
    corners = vertices[faces.indices]
    # Counted from a corner of the polygon, so that a face far from the origin loses no digits.
    corners -= corners[faces.offsets[:-1]][faces.corner_faces]
    x, y, z = corners.T
    x1, y1, z1 = corners[faces.next_corners].T
    crossed = np.stack([y * z1 - z * y1, z * x1 - x * z1, x * y1 - y * x1], axis=1)
    return 0.5 * np.add.reduceat(crossed, faces.offsets[:-1], axis=0)
