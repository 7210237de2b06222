"""What a USD file holds of a rig, and how far its straight pieces are from the curved paths."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

__all__ = ["BlendShapeReport", "UsdReport"]


@dataclass(frozen=True)
class BlendShapeReport:
    """How one morph stands in the file.

    Attributes:
        name: Name of the morph in the rig.
        prim_name: Its name in the file, where spaces, dots and accents are not allowed.
        inbetweens: Weights of its in-betweens, rising between 0 and 1.
        error: Largest distance between the straight pieces that UsdSkel plays and the curved
            path, as a fraction of D, for weights from 0 to 1 and besides the rounding to float32.
        straight_error: What it would be without in-betweens.
        points: Vertices that it moves.
    """

    name: str
    prim_name: str
    inbetweens: tuple[float, ...]
    error: float
    straight_error: float
    points: int


@dataclass(frozen=True)
class UsdReport:
    """What was written.

    Attributes:
        path: The file.
        size: Its size in bytes.
        tolerance: The error asked for, as a fraction of D.
        shapes: One entry a morph, in the order of the rig.
    """

    path: Path
    size: int
    tolerance: float
    shapes: tuple[BlendShapeReport, ...]

    @property
    def error(self) -> float:
        """The largest error of all morphs, as a fraction of D."""
        return max((shape.error for shape in self.shapes), default=0.0)

    @property
    def above_tolerance(self) -> tuple[BlendShapeReport, ...]:
        """The morphs for which the in-betweens allowed did not suffice."""
        return tuple(shape for shape in self.shapes if shape.error > self.tolerance)
