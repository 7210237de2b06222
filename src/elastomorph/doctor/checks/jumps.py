"""Vertices that jump: away from neighbours that agree among themselves."""

from __future__ import annotations

import numpy as np

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.neighbours import Neighbours
from elastomorph.doctor.stillness import QUARTER
from elastomorph.doctor.thresholds import Thresholds
from elastomorph.doctor.words import counted, listed, percent
from elastomorph.model.mesh import Mesh

__all__ = ["JumpCheck"]

# A vertex alone leaves the mean of its neighbours as far as their median; the mean is cheap, so
# only vertices that leave it by this part of the threshold are looked at closely.
_WORTH_A_LOOK = 0.5


class JumpCheck:
    """Looks at each vertex of a target among its neighbours."""

    def __init__(self, neutral: Mesh, around: Neighbours, thresholds: Thresholds) -> None:
        """Prepare for the targets of a neutral."""
        self._neutral, self._around, self._limits = neutral, around, thresholds

    def target(self, mesh: Mesh, file: str) -> list[Finding]:
        """Vertices of a target that jump."""
        moved = mesh.vertices - self._neutral.vertices
        off, edge = self._around.off_mean(moved), self._around.edge
        indices, starts = self._around.adjacent.indices, self._around.adjacent.indptr
        # Of vertices that are all a little off, the one that is farthest does not jump.
        noise = self._limits.jump_noise * float(np.quantile(off, QUARTER))
        least = np.maximum(self._limits.jump * edge, noise)
        worth_a_look = (off > _WORTH_A_LOOK * least) & (self._around.valence >= 3)
        jumping, far = [], 0.0
        for vertex in np.flatnonzero(worth_a_look).tolist():
            around = moved[indices[starts[vertex] : starts[vertex + 1]]]
            median = np.median(around, axis=0)
            leap = float(np.linalg.norm(moved[vertex] - median))
            spread = float(np.median(np.linalg.norm(around - median, axis=1)))
            clearly = self._limits.jump_clearly * edge[vertex] * spread
            alone = leap > self._limits.jump_alone * spread and leap**2 > clearly
            if alone and leap > least[vertex]:
                jumping.append(vertex)
                far = max(far, leap)
        if not jumping:
            return []
        scale = self._neutral.diameter or 1.0
        message = (
            f"{counted(jumping, 'vertex leaves its', 'vertices leave their')} neighbours by up to "
            f"{percent(far / scale)} of D: {listed(jumping)}"
        )
        return [finding("jumping-vertices", file, message, vertices=jumping)]
