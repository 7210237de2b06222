"""The neighbours of every vertex, and how far each vertex is from what they do on average."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from elastomorph.model.mesh import Mesh

__all__ = ["Neighbours"]


class Neighbours:
    """Who is joined to whom by an edge.

    Attributes:
        adjacent: (V, V) ones where an edge is.
        valence: (V,) number of neighbours, 1 where there are none.
        edge: (V,) mean length of the edges of each vertex.
    """

    def __init__(self, mesh: Mesh) -> None:
        """Look at the edges of a mesh."""
        count, edges = len(mesh.vertices), mesh.edges
        ends = np.concatenate([edges, edges[:, ::-1]])
        entries = (np.ones(len(ends)), (ends[:, 0], ends[:, 1]))
        self.adjacent = csr_array(coo_array(entries, shape=(count, count)))
        self.valence = np.maximum(np.diff(self.adjacent.indptr), 1)
        sides = mesh.vertices[ends[:, 0]] - mesh.vertices[ends[:, 1]]
        lengths = np.linalg.norm(sides, axis=1)
        self.edge = np.bincount(ends[:, 0], lengths, minlength=count) / self.valence

    def off_mean(self, moved: NDArray[np.float64]) -> NDArray[np.float64]:
        """(V,) how far the motion of each vertex is from the mean of its neighbours.

        Args:
            moved: (V, 3) motions.
        """
        mean = (self.adjacent @ moved) / self.valence[:, None]
        return np.asarray(np.linalg.norm(moved - mean, axis=1))
