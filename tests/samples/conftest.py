"""The built-in head with its layout, and what tests ask of a surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from elastomorph.model.mesh import Mesh
from elastomorph.samples import head
from sculptor.assembly import Head, build


@pytest.fixture(scope="session")
def whole() -> Head:
    """The built-in head, and what its vertices are: the layout it was sculpted on."""
    return replace(build(), mesh=head())


@pytest.fixture(scope="session")
def neutral(whole: Head) -> Mesh:
    """The built-in head."""
    return whole.mesh


def directed_edges(mesh: Mesh) -> NDArray[np.int64]:
    """(C, 2) every edge as each polygon runs along it."""
    start = mesh.faces.indices.astype(np.int64)
    return np.stack([start, start[mesh.faces.next_corners]], axis=1)


@pytest.fixture(scope="session")
def runs(neutral: Mesh) -> NDArray[np.int64]:
    """(C, 2) every edge of the head as each polygon runs along it."""
    return directed_edges(neutral)


@pytest.fixture(scope="session")
def pieces(neutral: Mesh, whole: Head) -> NDArray[np.int32]:
    """(V,) number of the connected component of each vertex."""
    from scipy import sparse
    from scipy.sparse.csgraph import connected_components

    a, b = neutral.edges.T
    count = len(neutral.vertices)
    graph = sparse.coo_array((np.ones(len(a)), (a, b)), shape=(count, count))
    labels: NDArray[np.int32] = connected_components(graph, directed=False)[1]
    return labels
