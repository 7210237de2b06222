"""The numbers that displacements are stored as: those that the targets of the file have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.io.gltf.container import GltfFile

_WHOLE = {5120: "|i1", 5122: "<i2"}
_FINER = {"|i1": "<i2"}


@dataclass(frozen=True)
class Encoding:
    """The type of the components of an accessor."""

    dtype: str
    normalized: bool

    @classmethod
    def of(cls, file: GltfFile, accessor: Any) -> Encoding:
        """That of an accessor of the file; single precision where there is none."""
        entry = {} if accessor is None else file.item("accessors", accessor, "a morph target")
        code = entry.get("componentType")
        dtype = _WHOLE.get(code, "<f4") if type(code) is int else "<f4"
        return cls(dtype, dtype != "<f4" and entry.get("normalized") is True)

    @property
    def finer(self) -> Encoding:
        """The next with more bits, for what these hold too roughly; itself where there is none."""
        return Encoding(_FINER.get(self.dtype, self.dtype), self.normalized)

    def encoded(
        self, values: NDArray[np.float64], *, directions: bool = False
    ) -> tuple[NDArray[Any], bool, NDArray[np.float64]]:
        """(N, 3) the numbers stored, whether they are normalized, and (N, 3) how far they are off.

        What does not fit into whole numbers is stored in single precision; of what turns directions
        such as normals, the few vectors that are too long are shortened.
        """
        kind = np.dtype(self.dtype)
        if kind.kind == "i":
            limits = np.iinfo(kind)
            unit = 1.0 / limits.max if self.normalized else 1.0
            if directions and self.normalized:
                values = values / np.maximum(1.0, np.abs(values).max(axis=1, keepdims=True))
            steps = np.round(values / unit)
            if np.abs(steps).max(initial=0.0) <= limits.max:
                return steps.astype(kind), self.normalized, steps * unit - values
        rows = values.astype(np.float32)
        return rows, False, rows - values
