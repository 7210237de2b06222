"""What a data set holds of each face beside its codes: contents, each one or more arrays.

A content is chosen when the data set is begun, as JSON in its attributes, from which every worker
makes the same content again. It says what its arrays are (`labels`), and makes rows of them from
codes; nothing else knows about it.

Vertices are stored as ``float32``, their positions, or as ``float16`` or ``int16``: displacements
from the neutral in units of a scale, the same for all. What the fields of a rig can do together is
bounded, so that no code of a data set can overflow, and the scale and the error are known before
the first face is made.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from elastomorph.blas_threads import in_own_threads
from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.columns import Columns
from elastomorph.model.surface import triangulate
from elastomorph.rig.build import extent_of
from elastomorph.rig.rig import Rig
from elastomorph.rig.sliders import table_moments

# Faces from codes of columns: products in which a face has the same bits in any company.
#
# The last bits of a sum in a matrix product depend on how many rows the product has and on which
# of them a face is. So all products have `TOGETHER` rows, and face i is always row i modulo that
# number.

TOGETHER = 32
"""Faces in one product."""

_BESIDE = 64  # Coordinates that stay still between two moved ones are cheaper multiplied than cut
_PRODUCTS = 4  # In a task of one thread: enough that starting it does not count

Rows = slice | NDArray[np.int64]


@dataclass(frozen=True)
class Run:
    """Consecutive coordinates that the fields move."""

    place: slice  # Of the 3V coordinates
    fields: NDArray[np.float32]  # (F, n) C-contiguous
    neutral: NDArray[np.float32]  # (n,)


@dataclass(frozen=True, eq=False)
class Poser:
    """The faces that rows of codes stand for.

    Args:
        rig: The rig.
        columns: What the codes mean; the first are the sliders of the rig.
    """

    rig: Rig
    columns: Columns

    def coefficients(self, codes: NDArray[np.uint16]) -> NDArray[np.float32]:
        """(S, F) what each field, Δ and bends of all morphs, is multiplied with in each face."""
        values = self.columns.decode(codes)
        sliders = values[:, : len(self.rig.names)]
        times = self.columns.times(values, len(self.rig.names))
        zeta, moments = table_moments(self.rig.sliders, sliders, times, normalize=False)
        blocks = [
            zeta[:, j, None] * morph.factors(moments[:, j])
            for j, morph in enumerate(self.rig.fields.morphs)
        ]
        return np.concatenate([np.zeros((len(codes), 0)), *blocks], axis=1).astype(np.float32)

    def positions(
        self,
        left: NDArray[np.float32],
        numbers: NDArray[np.int64],
        out: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]:
        """(S, V, 3) positions of the faces of these coefficients and (S,) numbers, on all cores."""
        shape = (len(left), *self.rig.neutral.vertices.shape)
        out = np.empty(shape, np.float32) if out is None else out
        flat = out.reshape(len(left), shape[1] * 3)

        def write(rows: Rows, run: Run, moved: NDArray[np.float32]) -> None:
            flat[rows, run.place] = np.add(moved, run.neutral, out=moved)

        for still in self.still:
            flat[:, still] = self._neutral[still]
        self.products(left, numbers, self._runs, write)
        return out

    def prepare(self) -> None:
        """Make once what all faces need."""
        _ = self._runs

    def runs(self, step: float = 1.0) -> list[Run]:
        """The coordinates that any field moves, in runs; fields in units of a step."""
        fields = self.rig.fields.matrix(np.float32)[1:]
        fields *= np.float32(1 / step)
        return [
            Run(run, np.ascontiguousarray(fields[:, run]), self._neutral[run])
            for run in self._moved
        ]

    def products(
        self,
        left: NDArray[np.float32],
        numbers: NDArray[np.int64],
        runs: list[Run],
        write: Callable[[Rows, Run, NDArray[np.float32]], object],
    ) -> None:
        """Hand on, of some faces and a run at a time, the (n, run) sums of fields.

        The sums are overwritten by the next; `write` is called by several threads.
        """
        widest = max((run.fields.shape[1] for run in runs), default=0)

        def work(some: list[tuple[Rows, Rows]]) -> None:
            buffer = np.empty(TOGETHER * widest, np.float32)
            whole = np.zeros((TOGETHER, left.shape[1]), np.float32)
            for rows, slots in some:
                whole[:] = 0
                whole[slots] = left[rows]
                for run in runs:
                    width = run.fields.shape[1]
                    sums = buffer[: TOGETHER * width].reshape(TOGETHER, width)
                    np.matmul(whole, run.fields, out=sums)
                    write(rows, run, sums[slots])

        parts = list(_products(numbers))
        in_own_threads(work, [parts[i : i + _PRODUCTS] for i in range(0, len(parts), _PRODUCTS)])

    @cached_property
    def _runs(self) -> list[Run]:
        return self.runs()

    @cached_property
    def still(self) -> list[slice]:
        """The runs of coordinates that nothing moves."""
        ends = [0, *(end for run in self._moved for end in (run.start, run.stop))]
        ends.append(self.rig.neutral.vertices.size)
        return [slice(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if a < b]

    @cached_property
    def _moved(self) -> list[slice]:
        moves = np.zeros(self.rig.neutral.vertices.shape, bool)
        for morph in self.rig.fields.morphs:
            for span in morph.spans:
                moves[span.vertices] |= span.fields.any(axis=0)
        moved = np.flatnonzero(moves)
        cuts = np.flatnonzero(np.diff(moved) > _BESIDE) + 1
        return [slice(int(r[0]), int(r[-1]) + 1) for r in np.split(moved, cuts) if len(r)]

    @cached_property
    def _neutral(self) -> NDArray[np.float32]:
        return self.rig.neutral.vertices.astype(np.float32).reshape(-1)


def _products(numbers: NDArray[np.int64]) -> Iterator[tuple[Rows, Rows]]:
    """Rows of faces that are multiplied together, and their rows in the product."""
    slots = numbers % TOGETHER
    order = np.argsort(slots, kind="stable")
    firsts = np.searchsorted(slots[order], np.arange(TOGETHER))
    product = np.empty(len(numbers), np.int64)  # the how-manieth face of its slot each face is
    product[order] = np.arange(len(numbers)) - firsts[slots[order]]
    by_product = np.lexsort((np.arange(len(numbers)), product))
    ends = np.flatnonzero(np.diff(product[by_product])) + 1
    for rows in np.split(by_product, ends) if len(numbers) else []:
        yield _as_slice(rows), _as_slice(slots[rows])


def _as_slice(rows: NDArray[np.int64]) -> Rows:
    """A slice where the rows follow each other: several times faster than an array of them."""
    first, count = int(rows[0]), len(rows)
    if (np.diff(rows) == 1).all():
        return slice(first, first + count)
    return rows


DTYPES = ("float32", "float16", "int16")
TOLERANCE = 1e-4
"""Of D: what int16 is to keep where nothing else is asked for and the rig allows it."""

_MOST = 32767 - 8  # Codes of int16, less what rounding in the product may add
ROUNDINGS = 64 * 2.0**-24
"""A product in single precision adds up to so many roundings of its largest partial sum."""


@dataclass(frozen=True)
class Encoding:
    """What numbers stand for the vertices of a face.

    Attributes:
        dtype: float32, float16 or int16.
        scale: Of a displacement; positions are neutral + scale · code, and the code itself for
            float32.
        error: The most by which a coordinate can differ from the rig's, in units of D.
    """

    dtype: str
    scale: float
    error: float

    @classmethod
    def of(cls, poser: Poser, dtype: str, tolerance: float | None) -> Encoding:
        """The encoding of a rig's faces that keeps a tolerance in units of D.

        Raises:
            ParameterError: An unknown type, or a tolerance that it cannot keep for this rig.
        """
        if dtype not in DTYPES:
            raise ParameterError(f"vertices are {', '.join(DTYPES)}, not {dtype!r}")
        if tolerance is not None and not (0 < tolerance < 1):
            raise ParameterError(
                f"the tolerance is a part of D above 0 and below 1, found {tolerance!r}"
            )
        rig = poser.rig
        extent = extent_of(rig) or 1.0
        reach = _largest_displacement(rig, poser.columns)
        size = float(np.abs(rig.neutral.vertices).max(initial=0)) + reach
        rounded = ROUNDINGS * reach / extent
        scale = 1.0
        if dtype == "float32":
            error = rounded + 2.0**-23 * size / extent
        elif dtype == "float16":
            scale = max(reach, extent) / 1024.0  # far from where float16 overflows or is denormal
            error = rounded + (2.0**-11 * reach + 2.0**-25 * scale) / extent
        else:
            least = reach / _MOST
            wanted = 2 * ((TOLERANCE if tolerance is None else tolerance) - rounded) * extent
            scale = max(least, wanted) if tolerance is None else wanted
            error = rounded + max(scale, least) / 2 / extent
        if tolerance is not None and error > tolerance * (1 + 1e-9):
            raise ParameterError(
                f"{dtype} keeps {error:.2g} of D for this rig, whose sliders move a vertex by up "
                f"to {reach / extent:.3g} D together: ask for that, or for float32"
            )
        return cls(dtype, float(scale), float(error))

    def attributes(self) -> dict[str, Any]:
        """What a reader needs to know of the array."""
        if self.dtype == "float32":
            return {"largest_error_of_D": self.error}
        return {"scale": self.scale, "offset": "neutral", "largest_error_of_D": self.error}

    def as_json(self) -> dict[str, Any]:
        """The fields by name."""
        return asdict(self)


@dataclass(frozen=True, eq=False)
class VertexEncoder:
    """Faces as the numbers that are stored, and back."""

    poser: Poser
    encoding: Encoding

    def encoded(self, left: NDArray[np.float32], numbers: NDArray[np.int64]) -> NDArray[np.generic]:
        """(S, V, 3) of the type of the encoding, of the faces of these coefficients and numbers."""
        if self.encoding.dtype == "float32":
            return self.poser.positions(left, numbers)
        shape = (len(left), *self.poser.rig.neutral.vertices.shape)
        out = np.empty(shape, self.encoding.dtype)
        flat = out.reshape(len(left), shape[1] * 3)
        whole = self.encoding.dtype == "int16"

        def write(rows: Rows, run: Run, moved: NDArray[np.float32]) -> None:
            if whole:
                np.rint(moved, out=moved)
            flat[rows, run.place] = moved

        for still in self.poser.still:
            flat[:, still] = 0
        self.poser.products(left, numbers, self._runs, write)
        return out

    def prepare(self) -> None:
        """Make once what all faces need."""
        if self.encoding.dtype == "float32":
            self.poser.prepare()
        else:
            _ = self._runs

    def decoded(self, stored: NDArray[Any]) -> NDArray[np.float32]:
        """(S, V, 3) float32 positions of what was stored."""
        if self.encoding.dtype == "float32":
            return np.asarray(stored, np.float32)
        found: NDArray[np.float32] = np.multiply(
            stored, np.float32(self.encoding.scale), dtype=np.float32
        )
        found += self._neutral
        return found

    @cached_property
    def _runs(self) -> list[Run]:
        return self.poser.runs(self.encoding.scale)

    @cached_property
    def _neutral(self) -> NDArray[np.float32]:
        return self.poser.rig.neutral.vertices.astype(np.float32)


def _largest_displacement(rig: Rig, columns: Columns) -> float:
    """No less than what any coordinate of any face can be moved by: Σ_j max |ζ_j (w^j(t) - V₀)|."""
    ranges = {column.name: (column.low, column.high) for column in columns}
    moved = np.zeros(rig.neutral.vertices.size)
    for name, morph in zip(rig.sliders.morphs, rig.fields.morphs, strict=True):
        low, high = ranges.get(name, (0.0, 0.0))
        if name in rig.sliders.correctives:
            own = rig.sliders.correctives[name]
            low, high = own.reach([ranges[driver] for driver in own.drivers])
        zeta = 1.0
        if "t" in ranges:
            zeta = max(abs(low), abs(high))
            low, high = ranges["t"]
        factors = [max(abs(low), abs(high))]
        for curve in morph.bend_curves:  # within [0, 1] at most its peak, straight outside
            factors.append(max(curve.height, abs(curve.at(low)), abs(curve.at(high))))
        for span in morph.spans:
            place = slice(3 * span.start, 3 * span.start + span.fields[0].size)
            for factor, part in zip(factors, span.fields, strict=True):
                moved[place] += zeta * factor * np.abs(part).reshape(-1)
    return float(moved.max(initial=0.0))


@dataclass(frozen=True)
class Label:
    """An array of a data set: what it holds of one face."""

    shape: tuple[int, ...]
    dtype: str
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def bytes(self) -> int:
        """Of one face, before they are compressed."""
        return math.prod(self.shape) * np.dtype(self.dtype).itemsize


class Faces:
    """Some faces while they are made.

    Attributes:
        codes: (S, C) of the columns.
        numbers: (S,) of the faces.
        coefficients: (S, F) of the rig's fields.
    """

    def __init__(
        self,
        poser: Poser,
        codes: NDArray[np.uint16],
        numbers: NDArray[np.int64],
        coefficients: NDArray[np.float32] | None = None,
    ) -> None:
        self.poser, self.codes, self.numbers = poser, codes, numbers
        self.coefficients = poser.coefficients(codes) if coefficients is None else coefficients

    def blocks(self, size: int) -> Iterator[Faces]:
        """The faces, so many at a time."""
        for start in range(0, len(self.codes), size):
            part = slice(start, start + size)
            yield Faces(self.poser, self.codes[part], self.numbers[part], self.coefficients[part])

    @cached_property
    def positions(self) -> NDArray[np.float32]:
        """(S, V, 3) in the space of the rig."""
        return self.poser.positions(self.coefficients, self.numbers)

    @cached_property
    def values(self) -> NDArray[np.float64]:
        """(S, C) of the columns."""
        return self.poser.columns.decode(self.codes)


IMAGES = "images/"
"""The folder of the arrays of pictures."""


class Content(ABC):
    """What makes some arrays of a data set."""

    labels: Mapping[str, Label]
    """Its arrays by name; a name may have folders, as ``images/colour``."""
    most: int = 2**16
    """Faces that one unit may have, so that what is lost with it is made in seconds."""

    def __init__(self, poser: Poser) -> None:
        self._poser = poser

    def prepare(self) -> None:
        """Make once what all rows need, before threads ask for it together: of most, the fields."""
        self._poser.prepare()

    def rounding(self, faces: Faces) -> float | NDArray[np.float64]:
        """By how much numbers may differ where another processor rounds, beside their last digits.

        Another one adds up products in another order, which is within what is compared with here
        for all that does not divide by something small.
        """
        return 0.0

    @abstractmethod
    def made(self, faces: Faces) -> Mapping[str, NDArray[Any]]:
        """(S, …) rows of each array."""


class Vertices(Content):
    """``vertices``: positions as numbers of an encoding."""

    def __init__(self, poser: Poser, chosen: Mapping[str, Any]) -> None:
        super().__init__(poser)
        encoding = Encoding(**chosen)
        self.encoder = VertexEncoder(poser, encoding)
        shape = poser.rig.neutral.vertices.shape
        self.labels: Mapping[str, Label] = {
            "vertices": Label(shape, encoding.dtype, encoding.attributes())
        }

    def prepare(self) -> None:
        """The fields in units of the scale."""
        self.encoder.prepare()

    def made(self, faces: Faces) -> Mapping[str, NDArray[Any]]:
        """Rows of ``vertices``."""
        return {"vertices": self.encoder.encoded(faces.coefficients, faces.numbers)}


class Normals(Content):
    """``normals``: of the vertices, of unit length, the mean of those of the triangles by area."""

    most = 2**12

    def __init__(self, poser: Poser, chosen: Mapping[str, Any]) -> None:
        super().__init__(poser)
        neutral = poser.rig.neutral
        self.labels: Mapping[str, Label] = {"normals": Label(neutral.vertices.shape, "float32")}
        self._triangles, shares = triangulate(neutral)
        corners, count = self._triangles.T.reshape(-1), len(self._triangles)
        entries = np.tile(shares, 3).astype(np.float32)
        places = (corners, np.tile(np.arange(count), 3))
        self._sums = csr_array((entries, places), shape=(len(neutral.vertices), count))

    def made(self, faces: Faces) -> Mapping[str, NDArray[Any]]:
        """Rows of ``normals``."""
        found = np.empty_like(faces.positions)
        for positions, normals in zip(faces.positions, found, strict=True):
            a, b, c = (positions[corner] for corner in self._triangles.T)
            normals[:] = self._sums @ np.cross(b - a, c - a)
            length = np.linalg.norm(normals, axis=1, keepdims=True)
            np.divide(normals, length, out=normals, where=length > 0)
        return {"normals": found}

    def rounding(self, faces: Faces) -> NDArray[np.float64]:
        """(S, V, 1) that follow from what positions can differ by; much at very small triangles.

        A normal is n / |n| with n = Σ s (b - a) × (c - a). Corners that differ by δ change each
        product by at most 2 δ (|b - a| + |c - a|), and the normal by twice what n changes by / |n|.
        """
        fields = np.abs(self._poser.rig.fields.matrix(np.float32)[1:])
        reach = (np.abs(faces.coefficients) @ fields).reshape(faces.positions.shape)
        apart = 2 * (ROUNDINGS * reach + 2.0**-23 * np.abs(faces.positions))  # Two processors
        found = np.empty((*faces.positions.shape[:2], 1))
        for positions, delta, rounding in zip(faces.positions, apart, found, strict=True):
            a, b, c = (positions[corner].astype(np.float64) for corner in self._triangles.T)
            lengths = np.linalg.norm(b - a, axis=1) + np.linalg.norm(c - a, axis=1)
            lengths *= np.linalg.norm(delta, axis=1)[self._triangles].max(axis=1)
            size = np.linalg.norm(self._sums @ np.cross(b - a, c - a), axis=1)
            rounding[:, 0] = 4 * (self._sums @ lengths) / np.maximum(size, 1e-300)
        return found


class Landmarks(Content):
    """``landmarks``: positions of named vertices."""

    def __init__(self, poser: Poser, chosen: Mapping[str, Any]) -> None:
        super().__init__(poser)
        self._vertices = np.array(list(chosen.values()), np.int64)
        attributes = {"names": list(chosen), "vertices": list(chosen.values())}
        self.labels: Mapping[str, Label] = {
            "landmarks": Label((len(chosen), 3), "float32", attributes)
        }

    def made(self, faces: Faces) -> Mapping[str, NDArray[Any]]:
        """Rows of ``landmarks``."""
        return {"landmarks": faces.positions[:, self._vertices]}


class Pictures(Content):
    """``images/…``: pictures of the faces and what is to be learned from them."""

    most = 2**7

    def __init__(self, poser: Poser, chosen: Mapping[str, Any]) -> None:
        from elastomorph.farm.pictures.painter import Painter

        super().__init__(poser)
        size = int(chosen["size"])
        self._painter = Painter(poser.rig, (size, size), chosen["landmarks"], chosen["arrays"])
        self.labels: Mapping[str, Label] = {
            f"{IMAGES}{name}": Label(*own) for name, own in self._painter.labels.items()
        }

    def made(self, faces: Faces) -> Mapping[str, NDArray[Any]]:
        """Rows of every image array."""
        columns = dict(zip(faces.poser.columns.names, faces.values.T, strict=True))
        drawn = self._painter.draw(faces.positions, columns)
        return {f"{IMAGES}{name}": rows for name, rows in drawn.items()}


CONTENTS: Mapping[str, Callable[[Poser, Mapping[str, Any]], Content]] = {
    "vertices": Vertices,
    "normals": Normals,
    "landmarks": Landmarks,
    "pictures": Pictures,
}
"""Each kind, by the name under which the attributes of a data set hold what was chosen."""


def contents_of(poser: Poser, chosen: Mapping[str, Any]) -> list[Content]:
    """The contents that the attributes of a data set name."""
    return [CONTENTS[name](poser, choice) for name, choice in chosen.items()]
