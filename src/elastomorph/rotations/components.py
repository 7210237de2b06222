"""The parts of a mesh that turn as a whole."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from elastomorph.rigid import fit_rigid
from elastomorph.rotations.rotation_vectors import nearest_quaternions

__all__ = ["common_turn"]

# How far a part may be from a rigid motion: as a fraction of D, so that noise of a scan does not
# matter, and of its own radius, so that a small part is not called rigid for being small.
_RIGID_OF_DIAMETER = 1e-3
_RIGID_OF_RADIUS = 0.02
# How far from an affine map, as a fraction of its radius: the rounding of a text file.
_AFFINE = 1e-5
# Parts thinner than this fraction of their length are flat: what happens across is not known.
_FLAT = 1e-3


def common_turn(
    start: NDArray[np.float64], end: NDArray[np.float64], diameter: float
) -> NDArray[np.float64] | None:
    """The one rotation of a part that turns as a whole.

    A part does so if a rigid motion carries it, up to a small residual, or an affine map: the
    rotation is then the polar factor of the map, none at all for a symmetric stretch.

    Args:
        start: (N, 3) its vertices in the neutral.
        end: (N, 3) in the target.
        diameter: D of the whole mesh.

    Returns:
        (4,) unit quaternion (w, x, y, z); or None where its vertices turn differently.
    """
    before, after = start - start.mean(axis=0), end - end.mean(axis=0)
    radius = float(np.linalg.norm(before, axis=1).max())
    if radius == 0.0:
        return np.array([1.0, 0.0, 0.0, 0.0])
    before, after = before / radius, after / radius
    affine, _, rank, _ = np.linalg.lstsq(before, after, rcond=_FLAT)
    if np.abs(before @ affine - after).max() <= _AFFINE:
        return np.asarray(nearest_quaternions(affine[None])[0])
    if rank >= 2:
        allowed = min(_RIGID_OF_DIAMETER * diameter, _RIGID_OF_RADIUS * radius)
        screw, residual = fit_rigid(start, end)
        if residual.max() <= allowed:
            return np.append(np.cos(screw.angle / 2), np.sin(screw.angle / 2) * screw.axis)
    return None
