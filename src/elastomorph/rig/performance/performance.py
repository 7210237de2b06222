"""A performance: recorded weights over time, and its frames on a rig.

How a recorded head is turned: the angles of a take, as rotations about the neck.

ARKit and Live Link Face count yaw to the head's own right, pitch downwards, and roll leaned to its
own left, in radians. In coordinates of glTF, where a face looks along +Z with +Y up, that is

    R = R_y(-yaw) R_x(pitch) R_z(-roll)

The viewer page has the same formula in ``web/viewer/rig/head.ts``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import as_times
from elastomorph.numbers import as_number, as_numbers, shown
from elastomorph.rig import Rig
from elastomorph.rig.naming import is_rotation
from elastomorph.rig.performance.matching import Match, match

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


_MOST_FRAMES = 10_000_000
_PART_OF_FRAME = 0.05


@dataclass(frozen=True, eq=False, repr=False)
class Performance:
    """Weights of a face over time, as a capture or an animator left them.

    Attributes:
        names: N names of weights, as in the file.
        times: (T,) float64, read-only, seconds, rising.
        weights: (T, N) float64, read-only; ordinarily 0 to 1, rotations in radians.
        rate: Nominal frames a second.
        timecodes: T timecodes, or none.
        dropped: Timecodes of frames that the numbering leaves out.
        dropped_times: (len(dropped),) float64, read-only, when they would have been.
        duplicates: Timecodes of frames that came again and were left out.
        source: Where it comes from.

    Raises:
        ParameterError: Shapes do not fit, names repeat, numbers are not finite, or times do not
            rise.
    """

    names: tuple[str, ...]
    times: NDArray[np.float64]
    weights: NDArray[np.float64]
    rate: float
    timecodes: tuple[str, ...]
    dropped: tuple[str, ...]
    dropped_times: NDArray[np.float64]
    duplicates: tuple[str, ...]
    source: str

    def __init__(
        self,
        names: Sequence[str],
        times: ArrayLike,
        weights: ArrayLike,
        rate: float,
        *,
        timecodes: Sequence[str] = (),
        dropped: Sequence[str] = (),
        dropped_times: ArrayLike = (),
        duplicates: Sequence[str] = (),
        source: str = "",
    ) -> None:
        texts = isinstance(names, Sequence) and all(isinstance(name, str) for name in names)
        if isinstance(names, str) or not texts:
            raise ParameterError(f"names must be a list of texts, found {shown(names)}")
        when = _numbers(times, "times", 1)
        table = _numbers(weights, "weights", 2)
        gone = _numbers(dropped_times, "dropped_times", 1)
        if not len(when) or table.shape != (len(when), len(names)):
            raise ParameterError(
                f"weights must have shape (T, N) with {len(when)} times T ≥ 1 and {len(names)} "
                f"names N, found {table.shape}"
            )
        if (np.diff(when) <= 0).any():
            row = int(np.argmax(np.diff(when) <= 0))
            raise ParameterError(
                f"times must rise, but {when[row]:g} s is followed by {when[row + 1]:g} s"
            )
        if len(set(names)) != len(names):
            twice = next(name for name in names if list(names).count(name) > 1)
            raise ParameterError(f"the weight {twice!r} is there twice; each needs its own name")
        rate = as_number(rate, "the rate", above=0.0)
        if timecodes and len(timecodes) != len(when):
            raise ParameterError(f"expected {len(when)} timecodes, found {len(timecodes)}")
        if len(gone) != len(dropped):
            raise ParameterError(f"expected {len(dropped)} dropped_times, found {len(gone)}")
        values = {
            "names": tuple(names),
            "times": when,
            "weights": table,
            "rate": rate,
            "timecodes": tuple(timecodes),
            "dropped": tuple(dropped),
            "dropped_times": gone,
            "duplicates": tuple(duplicates),
            "source": source,
        }
        for key, value in values.items():
            object.__setattr__(self, key, value)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return float(self.times[-1] - self.times[0])

    @property
    def rotations(self) -> tuple[str, ...]:
        """The names that are angles of the head and the eyes, not blendshapes."""
        return tuple(name for name in self.names if is_rotation(name))

    @property
    def head(self) -> NDArray[np.float64]:
        """(T, 3) how the head is turned, in radians: yaw, pitch, roll; 0 where nothing says it.

        Yaw turns it to its own right, pitch downwards, and roll leans it to its own left, as
        ``HeadYaw``, ``HeadPitch`` and ``HeadRoll`` of Live Link Face. They drive no slider;
        `elastomorph.rig.performance.head_rotations` makes matrices of them.
        """
        return head_angles(self.names, self.weights)

    def resampled(self, rate: float) -> Performance:
        """The performance at an even rate, interpolated linearly in time.

        Where frames were dropped, the weights go straight from one neighbour to the other and
        everything after keeps its time. The last frame is the last before the end, or the first
        after it if that is less than a twentieth of a frame late, as cameras run a little fast.

        Args:
            rate: Frames a second, above 0.

        Raises:
            ParameterError: The rate is not above 0, or asks for more than ten million frames.
        """
        rate = as_number(rate, "the rate", above=0.0)
        steps = self.duration * rate
        if steps > _MOST_FRAMES:
            raise ParameterError(
                f"{rate:g} frames a second of {self.duration:g} s are more than {_MOST_FRAMES:,} "
                "frames; choose a lower rate"
            )
        times = self.times[0] + np.arange(int(steps + _PART_OF_FRAME) + 1) / rate
        return Performance(self.names, times, self.at(times), rate, source=self.source)

    def at(self, times: ArrayLike) -> NDArray[np.float64]:
        """(N,) weights at a time in seconds, or (S, N) at (S,) of them.

        Before the start and after the end they hold.

        Raises:
            ParameterError: The times are neither a finite number nor one row of them.
        """
        when = as_times(times)
        if len(self.times) == 1:
            return np.broadcast_to(self.weights[0], (*when.shape, len(self.names))).copy()
        before = np.clip(np.searchsorted(self.times, when, side="right") - 1, 0, len(self) - 2)
        gaps = self.times[before + 1] - self.times[before]
        way = np.clip((when - self.times[before]) / gaps, 0.0, 1.0)[..., None]
        return np.asarray((1 - way) * self.weights[before] + way * self.weights[before + 1])

    def part(self, start: float = -np.inf, stop: float = np.inf) -> Performance:
        """The frames from one time to another, both included, at the times they have.

        Frames that were dropped between them are still named; duplicates are not.

        Args:
            start: Seconds.
            stop: Seconds.

        Raises:
            ParameterError: No frame lies between.
        """
        inside = np.flatnonzero((self.times >= start) & (self.times <= stop))
        if not inside.size:
            where = f"between {start:g} and {stop:g} s"
            if stop == np.inf or start == -np.inf:
                where = f"after {start:g} s" if stop == np.inf else f"before {stop:g} s"
            raise ParameterError(
                f"no frame lies {where}; the performance goes from {self.times[0]:g} to "
                f"{self.times[-1]:g} s"
            )
        first, last = int(inside[0]), int(inside[-1])
        gone = np.flatnonzero(
            (self.dropped_times > self.times[first]) & (self.dropped_times < self.times[last])
        )
        return Performance(
            self.names,
            self.times[first : last + 1],
            self.weights[first : last + 1],
            self.rate,
            timecodes=self.timecodes[first : last + 1],
            dropped=[self.dropped[i] for i in gone],
            dropped_times=self.dropped_times[gone],
            source=self.source,
        )

    def __len__(self) -> int:
        return len(self.times)

    def __repr__(self) -> str:
        return (
            f"Performance({len(self):,} frames, {len(self.names)} weights, "
            f"{self.rate:.5g} fps, {self.duration:.5g} s)"
        )


def slider_weights(
    rig: Rig, performance: Performance, by: Match | None = None, *, clip: bool = False
) -> NDArray[np.float64]:
    """(T, J) weights of the rig's sliders in each frame.

    Args:
        rig: The rig.
        performance: The recorded weights.
        by: Which weights drive which sliders; found by name where it is left out.
        clip: Keep the weights within 0 and 1. Otherwise a path goes on along its tangent.

    Raises:
        ParameterError: The match belongs to another recording or rig, or names are not clear.
    """
    own = match(performance.names, rig.names) if by is None else by
    if own.weights != performance.names or own.sliders != rig.names:
        raise ParameterError(
            "the match belongs to another recording or rig; make it with "
            "match(performance.names, rig.names)"
        )
    driven = own.drive(performance.weights)
    return np.clip(driven, 0.0, 1.0) if clip else driven


def play(
    rig: Rig,
    performance: Performance,
    by: Match | None = None,
    *,
    clip: bool = False,
    dtype: DTypeLike = np.float32,
    block: int | None = None,
) -> Iterator[NDArray[np.floating]]:
    """The frames of a performance, one face at a time, in fixed memory.

    Args:
        rig: The rig.
        performance: The recorded weights; resample it first for an even rate.
        by: Which weights drive which sliders; found by name where it is left out.
        clip: Keep the weights within 0 and 1.
        dtype: float32 or float64.
        block: Faces computed at once, as for `Rig.stream`.

    Yields:
        (V, 3) arrays that later ones overwrite, so copy what you keep.

    Raises:
        ParameterError: As `slider_weights`; as `Rig.stream`.
    """
    weights = slider_weights(rig, performance, by, clip=clip)
    for faces in rig.stream(weights, dtype=dtype, block=block):
        yield from faces


def _numbers(values: ArrayLike, what: str, dimensions: int) -> NDArray[np.float64]:
    array = as_numbers(values, what).copy()
    if array.ndim != dimensions or not np.isfinite(array).all():
        raise ParameterError(
            f"{what} must be finite numbers in {dimensions} dimension(s), found {array.shape}"
        )
    array.flags.writeable = False
    return array
