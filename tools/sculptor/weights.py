"""How strongly each vertex follows: soft hills on the skin, and the pull of the jaw."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from sculptor import layout, lids, lips
from sculptor.assembly import Head, build

__all__ = ["hill", "jaw_weights", "lid_grip"]

Weights = NDArray[np.float64]


def _frozen(values: Weights) -> Weights:
    values.flags.writeable = False
    return values


def hill(x: float, y: float, wide: float, high: float) -> Weights:
    """A smooth hill on the front of the skin, seen from the front.

    It resembles a Gaussian and is exactly zero three widths away; it fades out towards the
    mouth bag's end, and vertices at rest on the eyeballs, the teeth and the back stay at 0.

    Args:
        x: Centre, towards the character's left.
        y: Centre, upwards.
        wide: Width along x.
        high: Width along y.

    Returns:
        (V,) between 0 and 1.
    """
    points = build().mesh.vertices
    square = ((points[:, 0] - x) / wide) ** 2 + ((points[:, 1] - y) / high) ** 2
    return np.clip(1.0 - square / 9.0, 0.0, None) ** 4 * _front()


@cache
def _front() -> Weights:
    head = build()
    depth = np.clip((head.mesh.vertices[:, 2] - 1.0) / 4.0, 0.0, 1.0)
    weights = depth**2 * (3.0 - 2.0 * depth) * (head.part == "skin")
    return _frozen(weights * lid_grip())


@cache
def lid_grip() -> Weights:
    """(V,) how freely the skin slides: 0 on the lids, which only turn, 1 away from them."""
    head = build()
    grip = np.ones(len(head.part))
    for ring, free in ((2, 0.9), (3, 0.6), (lids.CREASE, 0.3)):
        grip[_both(head, head.lay.eye[ring])] = free
    grip[_both(head, head.lay.eye[lids.CREASE + 1 :])] = 0.0
    return _frozen(grip)


def _both(head: Head, indices: NDArray[np.int64]) -> NDArray[np.int64]:
    flat = indices.ravel()
    return np.concatenate([flat, head.partner[flat]])


@cache
def jaw_weights() -> Weights:
    """(V,) share of the jaw's turn that each vertex makes, 0 on the skull and 1 on the mandible.

    The smoothest weights, in the sense of the graph's bilaplacian, that are close to 1 on the
    chin, the lower lip and the floor of the mouth and to 0 on the skull, the upper lip and the
    neck. Lower teeth and tongue are exactly 1, the rest of the rigid parts exactly 0.
    """
    from scipy import sparse
    from scipy.sparse.linalg import splu

    head = build()
    count = len(head.part)
    target, trust = np.zeros(count), np.zeros(count)
    for value, indices, strength in _jaw_handles(head.lay):
        for own in (indices, head.partner[indices]):
            target[own], trust[own] = value, strength
    edges = head.mesh.edges
    one_way = sparse.csr_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), (count, count))
    link = sparse.csr_array(one_way + one_way.T)
    laplacian = sparse.csr_array(sparse.diags_array(np.asarray(link.sum(axis=1))) - link)
    skin = np.flatnonzero(head.part == "skin")
    smooth = laplacian[skin][:, skin]
    system = (smooth @ smooth + sparse.diags_array(trust[skin] + 1e-9)).tocsc()
    solver = splu(system, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    weights = np.zeros(count)
    weights[skin] = np.clip(solver.solve(trust[skin] * target[skin]), 0.0, 1.0)
    weights[(head.part == "lower_teeth") | (head.part == "tongue")] = 1.0
    weights = 0.5 * (weights + weights[head.partner])
    return _frozen(weights)


def _lip_weights(power: float) -> Weights:
    """Weights along a half ring of the mouth: 0 above, 1 below, shared at the corner."""
    reach = (np.arange(lips.STEPS + 1) / lips.STEPS) ** power
    return np.concatenate([0.44 * reach, (1.0 - 0.56 * reach)[-2::-1]])


def _jaw_handles(lay: layout.Half) -> list[tuple[float | Weights, NDArray[np.int64], float]]:
    """Weight, vertices and how firmly the weight is held there."""
    grid, mouth = lay.grid, lay.mouth
    lip_row, chin_row = layout.MOUTH.bottom, layout.MOUTH.bottom + 4
    skull = [
        grid[: layout.MOUTH.top - 1],
        grid[:, layout.EAR.front :],
        grid[chin_row + 6 :],
        lay.cap,
    ]
    lip, bag = _lip_weights(2.2), _lip_weights(6.0)
    handles: list[tuple[float | Weights, NDArray[np.int64], float]] = [
        (0.0, part[part >= 0], 10.0) for part in skull
    ]
    handles += [
        (0.0, lay.eye.ravel(), 10.0),
        (0.0, lay.nostril.ravel(), 10.0),
        (0.0, lay.ear.ravel(), 10.0),
        (0.0, lay.ear_floor.ravel(), 10.0),
        (np.tile(lip, 8), mouth[3:11].ravel(), 5.0),
        (np.tile(bag, 2), mouth[11:13].ravel(), 5.0),
        (1.0, grid[lip_row : chin_row + 1, 0:7].ravel(), 10.0),
        (0.9, grid[lip_row + 2 : chin_row + 1, 7:11].ravel(), 0.05),
        (0.6, grid[lip_row + 2 : chin_row + 1, 11:14].ravel(), 0.02),
        (0.75, grid[chin_row + 2, 0:5].ravel(), 0.02),
        (0.4, grid[chin_row + 3, 0:5].ravel(), 0.02),
    ]
    return handles
