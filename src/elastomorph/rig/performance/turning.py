"""How a recorded head is turned: the angles of a take, as rotations about the neck.

ARKit and Live Link Face count yaw to the head's own right, pitch downwards, and roll leaned to its
own left, in radians. In coordinates of glTF, where a face looks along +Z with +Y up, that is

    R = R_y(-yaw) R_x(pitch) R_z(-roll)

The viewer page has the same formula in ``web/viewer/rig/head.ts``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.numbers import as_numbers, shown

HEAD_ANGLES = ("HeadYaw", "HeadPitch", "HeadRoll")
"""What the angles are called in takes, in any capitals."""

_SIGNS = (-1.0, 1.0, -1.0)
_ORDER: Final = "YXZ"


def head_angles(names: Sequence[str], weights: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 3) yaw, pitch and roll among (T, N) weights of these names; 0 where there are none."""
    keys = [name.casefold() for name in names]
    angles = np.zeros((len(weights), 3))
    for axis, name in enumerate(HEAD_ANGLES):
        if name.casefold() in keys:
            angles[:, axis] = weights[:, keys.index(name.casefold())]
    return angles


def head_rotations(angles: ArrayLike) -> NDArray[np.float64]:
    """Rotations of a head that looks along +Z with +Y up.

    Args:
        angles: (T, 3) yaw to its own right, pitch downwards and roll to its own left, in radians.

    Returns:
        (T, 3, 3) matrices that turn columns, float64.

    Raises:
        ParameterError: Another shape, or numbers that are not finite.
    """
    from scipy.spatial.transform import Rotation

    matrices: NDArray[np.float64] = Rotation.from_euler(_ORDER, _checked(angles)).as_matrix()
    return matrices


def head_quaternions(angles: ArrayLike) -> NDArray[np.float64]:
    """(T, 4) the rotations of `head_rotations` as x, y, z, w, each on the side of the one before.

    So the way from one to the next is the short one.
    """
    from scipy.spatial.transform import Rotation

    found: NDArray[np.float64] = Rotation.from_euler(_ORDER, _checked(angles)).as_quat()
    if len(found):
        found[0] *= np.copysign(1.0, found[0, 3])
        same = np.einsum("ij,ij->i", found[1:], found[:-1]) >= 0
        found[1:] *= np.cumprod(np.where(same, 1.0, -1.0))[:, None]
    return found


def angles_of(quaternions: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T, 3) yaw, pitch and roll of (T, 4) quaternions x, y, z, w.

    The first pitch is within a quarter turn. Each other row is, of all angles that turn alike, near
    the one before, so that what lies between two frames is between them.
    """
    from scipy.spatial.transform import Rotation

    with catch_warnings():
        simplefilter("ignore")  # a head that looks straight down has no roll of its own
        found = Rotation.from_quat(quaternions).as_euler(_ORDER)
    angles: NDArray[np.float64] = found * _SIGNS + 0.0  # no -0
    other = angles * (1.0, -1.0, 1.0) + np.pi  # which turns alike
    same, across = (_way(each[1:] - angles[:-1]) for each in (angles, other))
    swapped = np.cumsum(np.concatenate([[False], across < same]), dtype=np.int64) % 2 == 1
    return np.unwrap(np.where(swapped[:, None], other, angles), axis=0)


def _way(change: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T,) how far it is by (T, 3) angles, whole turns aside."""
    distance: NDArray[np.float64] = np.linalg.norm(np.angle(np.exp(1j * change)), axis=1)
    return distance


@dataclass(frozen=True, eq=False)
class HeadTurn:
    """How a head is turned in each frame, and about which point.

    Attributes:
        pivot: (3,) float64, the neck, which stays where it is.
        angles: (T, 3) float64, as for `head_rotations`.

    Raises:
        ParameterError: Another shape, or numbers that are not finite.
    """

    pivot: NDArray[np.float64]
    angles: NDArray[np.float64]

    def __post_init__(self) -> None:
        pivot = as_numbers(self.pivot, "the neck")
        if pivot.shape != (3,) or not np.isfinite(pivot).all():
            raise ParameterError(f"the neck must be 3 finite numbers, found {shown(self.pivot)}")
        object.__setattr__(self, "pivot", pivot)
        object.__setattr__(self, "angles", _finite(self.angles))

    @cached_property
    def rotations(self) -> NDArray[np.float64]:
        """(T, 3, 3) matrices."""
        return head_rotations(self.angles)

    def of(self, positions: NDArray[np.float64], frame: int) -> NDArray[np.float64]:
        """(..., 3) positions as they are in a frame."""
        turned: NDArray[np.float64] = (positions - self.pivot) @ self.rotations[frame].T
        return turned + self.pivot

    def only(self, frames: NDArray[np.int64]) -> HeadTurn:
        """Some of the frames."""
        return HeadTurn(self.pivot, self.angles[frames])

    def __len__(self) -> int:
        return len(self.angles)


def _checked(angles: ArrayLike) -> NDArray[np.float64]:
    """(T, 3) turns about y, x and z."""
    return _finite(angles) * _SIGNS


def _finite(angles: ArrayLike) -> NDArray[np.float64]:
    found = as_numbers(angles, "head angles")
    if found.ndim != 2 or found.shape[1] != 3 or not np.isfinite(found).all():
        raise ParameterError(
            f"head angles must be finite numbers of shape (T, 3), found {found.shape}"
        )
    return found
