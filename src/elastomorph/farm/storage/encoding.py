"""How vertices are stored, and how far from the rig's faces what is stored can be.

``float32``: the positions. ``float16`` and ``int16``: displacements from the neutral in units of
a scale, the same for all. What the fields of a rig can do together is bounded, so that no code of
a data set can overflow, and the scale and the error are known before the first face is made.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ParameterError
from elastomorph.farm.sampling.columns import Columns
from elastomorph.farm.storage.posing import Poser, Rows, Run
from elastomorph.rig.build import extent_of
from elastomorph.rig.rig import Rig

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
        low, high = _product([ranges[own] for own in rig.sliders.correctives.get(name, (name,))])
        zeta = 1.0
        if "t" in ranges:
            zeta = max(abs(low), abs(high))
            low, high = ranges["t"]
        factors = [max(abs(low), abs(high))]
        for curve in morph.bend_curves:  # within [0, 1] at most its peak, straight outside
            factors.append(max(curve.height, abs(curve.at(low)), abs(curve.at(high))))
        for span in morph.spans:
            place = slice(3 * span.start, 3 * span.start + span.fields[0].size)
            for factor, field in zip(factors, span.fields, strict=True):
                moved[place] += zeta * factor * np.abs(field).reshape(-1)
    return float(moved.max(initial=0.0))


def _product(ranges: list[tuple[float, float]]) -> tuple[float, float]:
    """The least and the greatest product of numbers within ranges."""
    least, greatest = ranges[0]
    for low, high in ranges[1:]:
        ends = [a * b for a in (least, greatest) for b in (low, high)]
        least, greatest = min(ends), max(ends)
    return least, greatest
