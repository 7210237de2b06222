"""What an export wrote, and how far it can be from the rig."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["GlbReport"]


@dataclass(frozen=True)
class GlbReport:
    """What `write_glb` wrote. Errors are upper bounds for one slider between 0 and 1.

    Attributes:
        vertices: Vertices in the file: those of the mesh, and copies along texture seams.
        triangles: Triangles that the polygons were cut into.
        targets: Morph targets, Δ and bends together.
        bends: How many of them are bends.
        dropped_bends: Names of the bends that were too small to keep.
        bytes: Size of the file.
        parts: Bytes of its parts: ``json``, ``surface`` (indices, neutral, texture coordinates),
            ``positions`` and ``normals`` of the morph targets, and ``animations``.
        dropped_error: Largest distance by which a dropped bend moves a vertex, fraction of D.
        rounding_error: Largest error of storing in single precision, fraction of D.
        key_error: Largest error of an animation between its keys, fraction of D.
    """

    vertices: int
    triangles: int
    targets: int
    bends: int
    dropped_bends: tuple[str, ...]
    bytes: int
    dropped_error: float
    rounding_error: float
    key_error: float
    parts: Mapping[str, int] = field(default_factory=dict)

    @property
    def largest_error(self) -> float:
        """The three errors together, fraction of D."""
        return self.dropped_error + self.rounding_error + self.key_error
