"""Vertices renumbered while the polygons were not: the surface is torn to rags."""

from __future__ import annotations

import numpy as np

from elastomorph.doctor.findings import Finding, finding
from elastomorph.model.mesh import Mesh

__all__ = ["examine_scramble"]


def examine_scramble(neutral: Mesh, target: Mesh, file: str, allowed: float) -> list[Finding]:
    """Whether the edges of a target are those of the neutral at all.

    Args:
        neutral: The neutral.
        target: A target with its polygons, in its unit.
        file: Its file.
        allowed: How many times longer half of the edges may be.
    """
    edges = neutral.edges
    if not len(edges):
        return []
    before, after = (
        np.linalg.norm(mesh.vertices[edges[:, 0]] - mesh.vertices[edges[:, 1]], axis=1)
        for mesh in (neutral, target)
    )
    known = before > 0
    times = float(np.median(after[known] / before[known])) if known.any() else 0.0
    if times <= allowed:
        return []
    message = (
        f"the polygons are those of the neutral, but half of the edges are more than {times:.2g} "
        "times longer: the vertices are in another order under the same polygons"
    )
    return [finding("scrambled-vertices", file, message)]
