"""A solid of tetrahedra in equilibrium: linear elasticity, or corotational by warped stiffness."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.rivals.deformation_gradients import polar
from elastomorph.rivals.lattice import Lattice

# More do not help where flesh is folded between the jaw and the neck.
_MOST_TURNS = 12


@dataclass(frozen=True, eq=False)
class Pattern:
    """Where the blocks of all tetrahedra go in a sparse matrix, found once."""

    order: NDArray[np.int64]  # (16 K,) blocks sorted by row and column
    starts: NDArray[np.int64]  # (B,) where in it each block of the matrix starts
    rows: NDArray[np.int64]  # (N + 1,) where the blocks of each node's row start
    columns: NDArray[np.int64]  # (B,) the node of each block's column

    @classmethod
    def of(cls, tetrahedra: NDArray[np.int64], count: int) -> Pattern:
        """The pattern of so many nodes."""
        pairs = (tetrahedra[:, :, None] * count + tetrahedra[:, None]).ravel()
        order = np.argsort(pairs, kind="stable")
        blocks, starts = np.unique(pairs[order], return_index=True)
        rows = np.searchsorted(blocks, count * np.arange(count + 1))
        return cls(order, starts, rows, blocks % count)

    def summed(self, blocks: NDArray[np.float64]) -> Any:
        """(3 N, 3 N) the sum of (K, 4, 4, 3, 3) blocks."""
        from scipy.sparse import bsr_array

        values = np.add.reduceat(blocks.reshape(-1, 9)[self.order], self.starts, axis=0)
        count = 3 * (len(self.rows) - 1)
        parts = (values.reshape(-1, 3, 3), self.columns, self.rows)
        return bsr_array(parts, shape=(count, count)).tocsr()


@dataclass(frozen=True, eq=False)
class Solid:
    """Tetrahedra with the stiffness of each, to be warped and summed."""

    lattice: Lattice
    inverse: NDArray[np.float64]  # (K, 3, 3) of the sides at rest, as columns
    stiffness: NDArray[np.float64]  # (K, 4, 3, 4, 3)
    pattern: Pattern

    @classmethod
    def of(cls, lattice: Lattice, poisson: float, youngs: NDArray[np.float64]) -> Solid:
        """The stiffness of every tetrahedron, by scikit-fem, for (K,) Young's moduli."""
        from skfem import Basis, ElementTetP1, ElementVector, MeshTet
        from skfem.models.elasticity import lame_parameters, linear_elasticity

        mesh = MeshTet(lattice.nodes.T.copy(), lattice.tetrahedra.T.copy(), sort_t=False)
        basis = Basis(mesh, ElementVector(ElementTetP1()), intorder=1)
        form = linear_elasticity(*lame_parameters(1.0, poisson))
        local = form.coo_data(basis).tolocal()
        sides = _sides(lattice.nodes, lattice.tetrahedra)
        local *= youngs[:, None, None]
        stiffness = local.reshape(-1, 4, 3, 4, 3)
        pattern = Pattern.of(lattice.tetrahedra, len(lattice.nodes))
        return cls(lattice, np.asarray(np.linalg.inv(sides)), stiffness, pattern)

    def turns(self, nodes: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K, 3, 3) the nearest rotation to the gradient of each tetrahedron."""
        return polar(_sides(nodes, self.lattice.tetrahedra) @ self.inverse)[0]

    def linear(self, bones: NDArray[np.float64], bone: NDArray[np.bool_]) -> NDArray[np.float64]:
        """(N, 3) the equilibrium of linear elasticity for given bones."""
        still = np.tile(np.eye(3), (len(self.inverse), 1, 1))
        return self._solved(still, self.lattice.nodes, bones, bone)

    def settled(
        self,
        nodes: NDArray[np.float64],
        bones: NDArray[np.float64],
        bone: NDArray[np.bool_],
        smallest: float,
    ) -> NDArray[np.float64]:
        """(N, 3) the corotational equilibrium for given bones, found from nodes near it."""
        # The turns of before: bones that have moved alone fold the flesh beside them.
        nodes = self._solved(self.turns(nodes), nodes, bones, bone)
        part, before = 1.0, np.inf
        for _ in range(_MOST_TURNS):
            step = self._solved(self.turns(nodes), nodes, bones, bone) - nodes
            moved = float(np.abs(step).max())
            nodes += part * step
            if moved < smallest:
                break
            # Where flesh folds, turns and places may chase each other in a circle.
            part, before = (part if moved < before else max(0.7 * part, 0.3)), moved
        return nodes

    def _solved(
        self,
        turns: NDArray[np.float64],
        guess: NDArray[np.float64],
        bones: NDArray[np.float64],
        bone: NDArray[np.bool_],
    ) -> NDArray[np.float64]:
        """(N, 3) where the forces on all nodes but bones vanish, for given rotations."""
        from scipy.sparse import diags_array
        from scipy.sparse.linalg import cg

        own = self.lattice.tetrahedra
        half = np.einsum("kij,kajbl->kaibl", turns, self.stiffness)
        pulls = np.einsum("kaibl,kbl->kai", half, self.lattice.nodes[own])
        matrix = self.pattern.summed(np.einsum("kaibl,kml->kabim", half, turns))
        slots = 3 * own[:, :, None] + np.arange(3)
        force = np.bincount(slots.ravel(), pulls.ravel(), minlength=guess.size)
        given = np.repeat(bone, 3)
        free = matrix[~given]
        known = force[~given] - free[:, given] @ bones.ravel()
        inner = free[:, ~given]
        inverse: Any = diags_array(1.0 / inner.diagonal())
        start = guess.ravel()[~given]
        found = guess.copy()
        found[bone] = bones
        solution, _ = cg(inner, known, x0=start, rtol=1e-7, maxiter=5000, M=inverse)
        found[~bone] = solution.reshape(-1, 3)
        return found


def _sides(nodes: NDArray[np.float64], tetrahedra: NDArray[np.int64]) -> NDArray[np.float64]:
    """(K, 3, 3) three sides of each tetrahedron, as columns."""
    corners = nodes[tetrahedra]
    return np.swapaxes(corners[:, 1:] - corners[:, :1], 1, 2)
