"""The parts of a mesh that turn as a whole."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from elastomorph.paths.rotations.rotation_vectors import nearest_quaternions, rotated

__all__ = ["common_turns"]

# How far a part may be from a rigid motion: as a fraction of D, so that noise of a scan does not
# matter, and of its own radius, so that a small part is not called rigid for being small.
_RIGID_OF_DIAMETER = 1e-3
_RIGID_OF_RADIUS = 0.02
# How far from an affine map, as a fraction of its radius: the rounding of a text file.
_AFFINE = 1e-5
# Parts thinner than this fraction of their length are flat: what happens across is not known.
_FLAT = 1e-3


def common_turns(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    parts: Sequence[NDArray[np.int64]],
    diameter: float,
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """The one rotation of each part that turns as a whole.

    A part does so if a rigid motion carries it, up to a small residual, or an affine map: the
    rotation is then the polar factor of the map, none at all for a symmetric stretch.

    Args:
        start: (V, 3) positions in the neutral.
        end: (V, 3) in the target.
        parts: Vertices of each of P parts, none of them empty.
        diameter: D of the whole mesh.

    Returns:
        (P, 4) unit quaternions (w, x, y, z), and (P,) whether the part turns by it as a whole.
    """
    if not parts:
        return np.zeros((0, 4)), np.zeros(0, dtype=bool)
    sizes = np.array([len(part) for part in parts])
    firsts, part_of = np.cumsum(sizes) - sizes, np.repeat(np.arange(len(parts)), sizes)
    vertices = np.concatenate(parts)

    def centred(points: NDArray[np.float64]) -> NDArray[np.float64]:
        mine = points[vertices]
        means = np.add.reduceat(mine, firsts, axis=0) / sizes[:, None]
        return np.asarray(mine - means[part_of])

    def longest(offsets: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(np.maximum.reduceat(np.linalg.norm(offsets, axis=1), firsts))

    before, after = centred(start), centred(end)
    radius = longest(before)
    unit = np.where(radius > 0, radius, 1.0)
    before, after = before / unit[part_of, None], after / unit[part_of, None]
    own, joint = (
        np.add.reduceat(before[:, :, None] * other[:, None, :], firsts) for other in (before, after)
    )
    affine, rank = _affine(own, joint)
    missed = longest(np.einsum("vi,vij->vj", before, affine[part_of]) - after)
    is_affine = (missed <= _AFFINE) | (radius == 0)
    turns = nearest_quaternions(np.where(is_affine[:, None, None], affine, joint))
    turns[radius == 0] = 1.0, 0.0, 0.0, 0.0
    residual = radius * longest(rotated(turns[part_of], before) - after)
    allowed = np.minimum(_RIGID_OF_DIAMETER * diameter, _RIGID_OF_RADIUS * radius)
    return turns, is_affine | ((rank >= 2) & (residual <= allowed))


def _affine(
    own: NDArray[np.float64], joint: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(P, 3, 3) the maps x → xA nearest to the motions, nothing across flat parts, and the ranks.

    Args:
        own: (P, 3, 3) Σ x₀ᵀ x₀.
        joint: (P, 3, 3) Σ x₀ᵀ x₁.
    """
    squares, axes = np.linalg.eigh(own)
    known = squares > _FLAT**2 * squares[:, -1:]
    inverse = np.divide(1.0, squares, out=np.zeros_like(squares), where=known)
    return (axes * inverse[:, None, :]) @ (axes.transpose(0, 2, 1) @ joint), known.sum(axis=1)
