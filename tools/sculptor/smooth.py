"""Skin that follows: the smoothest displacement through what some vertices are asked to do."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sculptor.assembly import build
from sculptor.implicit import Points

if TYPE_CHECKING:
    from scipy import sparse

__all__ = ["Pull", "follow"]

Pull = tuple[NDArray[np.int64], Points | float, NDArray[np.float64] | float]
"""Vertices, where they shall go (displacements, or 0) and how firmly."""


@cache
def _bending() -> sparse.csr_array:
    """The square of the graph's Laplacian, near neighbours counting more: (V, V)."""
    from scipy import sparse

    mesh = build().mesh
    a, b = mesh.edges.T
    near = 1.0 / np.linalg.norm(mesh.vertices[a] - mesh.vertices[b], axis=1)
    count = len(mesh.vertices)
    one_way = sparse.csr_array((near, (a, b)), (count, count))
    link = sparse.csr_array(one_way + one_way.T)
    mean = sparse.diags_array(1.0 / np.asarray(link.sum(axis=1))) @ link
    laplacian = sparse.csr_array(sparse.eye_array(count) - mean)
    return sparse.csr_array(laplacian.T @ laplacian)


def follow(pulls: list[Pull]) -> Points:
    """The displacement of the skin that bends least, pulled where it is asked to be.

    It minimises Σ|Lu|² + Σ wᵢ|uᵢ − tᵢ|² with the Laplacian L of the mesh's graph. Several pulls at
    one vertex add up. Teeth, tongue and eyeballs stay.

    Returns:
        (V, 3).
    """
    from scipy import sparse
    from scipy.sparse.linalg import splu

    head = build()
    skin = np.flatnonzero(head.part == "skin")
    firm = np.full(len(head.part), 1e-9)
    wanted = np.zeros((len(head.part), 3))
    for vertices, targets, strength in pulls:
        np.add.at(firm, vertices, strength)
        weighed = np.broadcast_to(np.asarray(strength)[..., None] * targets, (len(vertices), 3))
        np.add.at(wanted, vertices, weighed)
    system = _bending()[skin][:, skin] + sparse.diags_array(firm[skin])
    solver = splu(system.tocsc(), permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    moved = np.zeros_like(wanted)
    moved[skin] = solver.solve(wanted[skin])
    return moved
