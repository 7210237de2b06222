"""Targets that do nothing, and targets that do the same."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from elastomorph.doctor.findings import Finding, finding
from elastomorph.model.mesh import Mesh

__all__ = ["does_nothing", "examine_doubles"]


def does_nothing(neutral: Mesh, target: Mesh, file: str, allowed: float) -> list[Finding]:
    """Whether a target moves any vertex.

    Args:
        neutral: The neutral.
        target: A target in its order.
        file: Its file.
        allowed: Largest motion that is none, as a fraction of D.
    """
    farthest = float(np.abs(target.vertices - neutral.vertices).max())
    if farthest > allowed * (neutral.diameter or 1.0):
        return []
    message = "it is the neutral" if farthest == 0 else "it differs from the neutral by rounding"
    return [finding("does-nothing", file, message)]


def examine_doubles(neutral: Mesh, targets: Mapping[str, Mesh], allowed: float) -> list[Finding]:
    """Targets of the same shape as one before.

    Args:
        neutral: The neutral.
        targets: Targets that do something, by their file.
        allowed: Largest difference that is none, as a fraction of D.
    """
    if len(targets) < 2:
        return []
    limit = allowed * (neutral.diameter or 1.0)
    files = list(targets)
    # A few sums over all coordinates differ wherever shapes do; only where they are close is it
    # worth to compare all vertices. The weights sum to at most 1, so sums differ less than shapes.
    count = neutral.vertices.size
    weights = np.random.default_rng(0).uniform(-1.0, 1.0, (4, count)) / count
    sums = np.stack([weights @ mesh.vertices.ravel() for mesh in targets.values()])
    found = []
    for late in range(1, len(files)):
        near = np.flatnonzero(np.abs(sums[:late] - sums[late]).max(axis=1) <= limit)
        for early in near.tolist():
            difference = targets[files[early]].vertices - targets[files[late]].vertices
            if float(np.abs(difference).max()) <= limit:
                message = f"the same shape as {Path(files[early]).name}"
                found.append(finding("duplicate-targets", files[late], message))
                break
    return found
