"""Vertices that jump: away from neighbours that agree among themselves."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.thresholds import Thresholds
from elastomorph.doctor.words import counted, listed, percent
from elastomorph.mesh import Mesh

__all__ = ["JumpCheck"]

# A vertex alone leaves the mean of its neighbours as far as their median; the mean is cheap, so
# only vertices that leave it by this part of the threshold are looked at closely.
_WORTH_A_LOOK = 0.5


class JumpCheck:
    """Knows the neighbours of every vertex, and how long the edges are."""

    def __init__(self, neutral: Mesh, thresholds: Thresholds) -> None:
        """Prepare for the targets of a neutral."""
        self._neutral, self._limits = neutral, thresholds
        count, edges = len(neutral.vertices), neutral.edges
        ends = np.concatenate([edges, edges[:, ::-1]])
        ones = np.ones(len(ends))
        shape = (count, count)
        self._adjacent = csr_array(coo_array((ones, (ends[:, 0], ends[:, 1])), shape=shape))
        self._valence = np.maximum(np.diff(self._adjacent.indptr), 1)
        sides = neutral.vertices[ends[:, 0]] - neutral.vertices[ends[:, 1]]
        lengths = np.linalg.norm(sides, axis=1)
        self._edge = np.bincount(ends[:, 0], lengths, minlength=count) / self._valence

    def target(self, mesh: Mesh, file: str) -> list[Finding]:
        """Vertices of a target that jump."""
        moved = mesh.vertices - self._neutral.vertices
        mean = (self._adjacent @ moved) / self._valence[:, None]
        off = np.linalg.norm(moved - mean, axis=1)
        indices, starts = self._adjacent.indices, self._adjacent.indptr
        least = self._limits.jump * self._edge
        jumping, far = [], 0.0
        for vertex in np.flatnonzero((off > _WORTH_A_LOOK * least) & (self._valence >= 3)).tolist():
            around = moved[indices[starts[vertex] : starts[vertex + 1]]]
            median = np.median(around, axis=0)
            leap = float(np.linalg.norm(moved[vertex] - median))
            spread = float(np.median(np.linalg.norm(around - median, axis=1)))
            clearly = self._limits.jump_clearly * self._edge[vertex] * spread
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
