"""Displacements saved in place of a shape: most vertices lie at the origin."""

from __future__ import annotations

import numpy as np

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.frames import frame_between
from elastomorph.doctor.thresholds import Thresholds
from elastomorph.doctor.words import percent
from elastomorph.model.mesh import Mesh
from elastomorph.model.rigid import fit_rigid

__all__ = ["examine_deltas"]

# A shape that is no neutral however it is moved, scaled and turned leaves this part of its extent.
_UNLIKE = 0.3


def examine_deltas(
    neutral: Mesh, target: Mesh, file: str, limits: Thresholds
) -> tuple[Finding, Mesh | None] | None:
    """Whether a target holds displacements, and the shape they make.

    Args:
        neutral: The neutral.
        target: A target in its order.
        file: Its file.
        limits: From where on to report.

    Returns:
        The finding, and the target with the neutral added, or None where displacements are so
        large that they are of another unit, and nothing says of which; None for a shape.
    """
    scale = neutral.diameter
    points = target.vertices
    if not scale or len(points) < 4:
        return None
    at_origin = float((np.linalg.norm(points, axis=1) <= limits.nothing * scale).mean())
    largest = float(np.linalg.norm(points, axis=1).max()) / scale
    small = largest < limits.deltas
    if at_origin < limits.resting and not (small and _is_unlike(neutral, target)):
        return None
    if not small:
        if not _is_unlike(neutral, target):
            return None
        message = (
            "its coordinates are displacements from the neutral, no positions, and in another "
            f"unit: the largest is {percent(largest)} of D, farther than any expression reaches; "
            "nothing says which unit, so it is not repaired"
        )
        return finding("saved-as-deltas", file, message), None
    shape = target.with_vertices(neutral.vertices + points)
    if not frame_between(neutral.vertices, shape.vertices, limits.scale).is_same:
        return None
    message = (
        f"its coordinates are displacements from the neutral, no positions: {percent(at_origin)} "
        "of its vertices are at the origin"
    )
    return finding("saved-as-deltas", file, message), shape


def _is_unlike(neutral: Mesh, target: Mesh) -> bool:
    """Whether a target is not the neutral in another unit either."""
    here = neutral.vertices - neutral.vertices.mean(axis=0)
    there = target.vertices - target.vertices.mean(axis=0)
    sizes = [float(np.sqrt((points**2).sum())) for points in (here, there)]
    if min(sizes) == 0:
        return False
    _, left = fit_rigid(here / sizes[0], there / sizes[1])
    return bool((left**2).sum() / 2.0 > _UNLIKE)
