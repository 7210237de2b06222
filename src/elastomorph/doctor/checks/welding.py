"""Vertices at one and the same position: seams left open, or parts that touch."""

from __future__ import annotations

import numpy as np

from elastomorph.doctor.findings import Finding, finding
from elastomorph.doctor.words import counted
from elastomorph.model.components import component_of
from elastomorph.model.mesh import Mesh

__all__ = ["examine_welding"]


def examine_welding(mesh: Mesh, file: str) -> list[Finding]:
    """Vertices that share their position with another one."""
    order = np.lexsort(mesh.vertices.T)
    ordered = mesh.vertices[order]
    new = np.append(True, (ordered[1:] != ordered[:-1]).any(axis=1))
    place = np.cumsum(new) - 1
    shared = np.bincount(place)[place] > 1
    if not shared.any():
        return []
    pieces = component_of(len(mesh.vertices), mesh.edges)[order[shared]]
    keys = place[shared].astype(np.int64) * (int(pieces.max()) + 1) + pieces
    _, counts = np.unique(keys, return_counts=True)
    seams = int((counts > 1).sum())
    positions = len(np.unique(place[shared]))
    where = (
        "all where different pieces touch"
        if not seams
        else f"{seams:,} of them twice on one piece, as an open seam has"
    )
    message = (
        f"{int(shared.sum()):,} vertices share {counted(positions, 'position', 'positions')}, "
        f"{where}"
    )
    return [finding("unwelded-vertices", file, message, vertices=np.sort(order[shared]).tolist())]
