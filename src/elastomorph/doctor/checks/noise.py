"""Noise: no vertex of a target goes quite where its neighbours go, not even where it rests."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.neighbours import Neighbours
from elastomorph.doctor.stillness import QUARTER
from elastomorph.doctor.thresholds import Thresholds
from elastomorph.doctor.words import percent
from elastomorph.model.mesh import Mesh

__all__ = ["examine_noise", "roughness"]


def roughness(neutral: Mesh, target: Mesh, around: Neighbours) -> float:
    """How far the smoothest quarter of the vertices leaves the mean of its neighbours at most.

    An expression rests, or moves smoothly, in more than a quarter of the face; noise is everywhere.

    Args:
        neutral: The neutral.
        target: A target as it should be.
        around: The neighbours in the neutral.

    Returns:
        A part of the mean edge of the vertex.
    """
    joined = around.edge > 0
    if not joined.any():
        return 0.0
    off = around.off_mean(target.vertices - neutral.vertices)
    return float(np.quantile(off[joined] / around.edge[joined], QUARTER))


def examine_noise(rough: Mapping[str, float], limits: Thresholds) -> list[Finding]:
    """Targets that are noisier than the others.

    Where most targets are noisy, that is how the face was captured and no fault of one of them.

    Args:
        rough: `roughness` of each target, by file.
        limits: From where on to report.
    """
    if not rough:
        return []
    usual = float(np.median(list(rough.values()))) if len(rough) > 1 else 0.0
    least = max(limits.noise, limits.noise_alone * usual)
    return [
        finding(
            "noise",
            file,
            "three quarters of its vertices leave the mean of their neighbours by more than "
            f"{percent(own)} of an edge, where a clean target rests or moves smoothly",
        )
        for file, own in rough.items()
        if own > least
    ]
