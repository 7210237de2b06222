"""A mesh of a scene: vertices, triangles, and what the morph targets move."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = ["Piece", "SceneSurface", "Sheet"]


@dataclass(frozen=True, eq=False)
class Sheet:
    """Vertices that one or several primitives share.

    Attributes:
        start: Number of the first of them among all vertices.
        vertices: (N, 3) float64, in place.
        texture: (N, 2) float64 with v from the top, if any.
        displacements: What each morph target moves, (N, 3) float64, by its name.
    """

    start: int
    vertices: NDArray[np.float64]
    texture: NDArray[np.float64] | None
    displacements: dict[str, NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class Piece:
    """The triangles of one primitive.

    Attributes:
        triangles: (T, 3) int32, of all vertices.
        material: Name of the material, if any.
    """

    triangles: NDArray[np.int32]
    material: str | None


@dataclass(eq=False)
class SceneSurface:
    """A mesh with all its primitives, in place.

    Attributes:
        targets: Names of the morph targets, in order.
        sheets: The vertices.
        pieces: The triangles.
    """

    targets: list[str] = field(default_factory=list)
    sheets: list[Sheet] = field(default_factory=list)
    pieces: list[Piece] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Number of vertices."""
        return self.sheets[-1].start + len(self.sheets[-1].vertices) if self.sheets else 0

    def vertices(self) -> NDArray[np.float64]:
        """(V, 3) positions of all vertices."""
        return np.concatenate([sheet.vertices for sheet in self.sheets])

    def texture(self) -> NDArray[np.float64] | None:
        """(V, 2) texture coordinates, v from the top, NaN where there are none; or None."""
        if all(sheet.texture is None for sheet in self.sheets):
            return None
        return np.concatenate(
            [
                np.full((len(sheet.vertices), 2), np.nan)
                if sheet.texture is None
                else sheet.texture
                for sheet in self.sheets
            ]
        )

    def displacement(self, target: str) -> NDArray[np.float64]:
        """(V, 3) what a morph target moves."""
        found = np.zeros((self.count, 3))
        for sheet in self.sheets:
            if target in sheet.displacements:
                stop = sheet.start + len(sheet.vertices)
                found[sheet.start : stop] = sheet.displacements[target]
        return found
