"""Performances: recorded weights over time, matched to the sliders of a rig and played on it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Final, NamedTuple
from warnings import catch_warnings, simplefilter

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import as_times
from elastomorph.numbers import as_number, as_numbers, first_few, shown
from elastomorph.rig import Rig
from elastomorph.rig.naming import is_rotation, nearest_name, shape_of, wholes
from elastomorph.rig.timing import Timing, smoothstep

# Which weights of a recording drive which sliders of a rig.


class Drive(NamedTuple):
    """What drives one slider: the sum of weights, each times its factor.

    Attributes:
        names: Names of weights.
        factors: One factor each.
    """

    names: tuple[str, ...]
    factors: tuple[float, ...]


@dataclass(frozen=True)
class Match:
    """Which weights of a recording drive which sliders of a rig.

    Attributes:
        weights: Names in the recording, the columns that `drive` takes.
        sliders: Names on the rig, the columns that `drive` returns.
        drives: What drives each slider; those that nothing drives are left out.

    Raises:
        ParameterError: It names a weight or slider that is not there.
    """

    weights: tuple[str, ...]
    sliders: tuple[str, ...]
    drives: Mapping[str, Drive]

    def __post_init__(self) -> None:
        drives = {slider: Drive(*drive) for slider, drive in self.drives.items()}
        for slider, drive in drives.items():
            if slider not in self.sliders:
                raise ParameterError(f"the rig has no slider {slider!r} to drive")
            for name in drive.names:
                if name not in self.weights:
                    raise ParameterError(f"the recording has no weight {name!r} for {slider!r}")
            if len(drive.names) != len(drive.factors) or not np.isfinite(drive.factors).all():
                raise ParameterError(f"the slider {slider!r} needs one finite factor a weight")
        object.__setattr__(self, "drives", MappingProxyType(drives))

    @property
    def rotations(self) -> tuple[str, ...]:
        """Weights that are angles of the head and the eyes; they never drive a slider."""
        return tuple(name for name in self.weights if is_rotation(name))

    @property
    def unmatched_weights(self) -> tuple[str, ...]:
        """Weights in the recording that drive nothing, without the rotations."""
        used = {name for drive in self.drives.values() for name in drive.names}
        return tuple(n for n in self.weights if n not in used and not is_rotation(n))

    @property
    def unmatched_sliders(self) -> tuple[str, ...]:
        """Sliders on the rig that nothing drives: they stay at 0."""
        return tuple(name for name in self.sliders if name not in self.drives)

    @cached_property
    def factors(self) -> NDArray[np.float64]:
        """(N, J) what each weight adds to each slider."""
        table = np.zeros((len(self.weights), len(self.sliders)))
        for slider, drive in self.drives.items():
            column = self.sliders.index(slider)
            for name, factor in zip(drive.names, drive.factors, strict=True):
                table[self.weights.index(name), column] += factor
        return table

    def drive(self, weights: ArrayLike) -> NDArray[np.float64]:
        """(T, J) slider weights, in the order of the rig.

        Args:
            weights: (T, N) recorded weights.

        Raises:
            ParameterError: Another shape, or numbers that are not finite.
        """
        table = np.asarray(weights, dtype=np.float64)
        if table.ndim != 2 or table.shape[1] != len(self.weights):
            raise ParameterError(
                f"weights must have shape (T, {len(self.weights)}), found {table.shape}"
            )
        if not np.isfinite(table).all():
            raise ParameterError("weights must be finite numbers")
        return table @ self.factors

    def text(self, most: int | None = None) -> str:
        """The match for people: what drives what under another name, and what is left over.

        Args:
            most: How many of a kind are named; all by default.
        """
        used = len(self.weights) - len(self.rotations) - len(self.unmatched_weights)
        lines = [
            f"{used} of {len(self.weights) - len(self.rotations)} weights drive "
            f"{len(self.drives)} of {len(self.sliders)} sliders"
        ]
        otherwise = [
            f"  {slider} = {_formula(drive)}"
            for slider, drive in self.drives.items()
            if drive.factors != (1.0,) or shape_of(slider) != shape_of(drive.names[0])
        ]
        lines += otherwise[:most]
        if len(otherwise) > len(otherwise[:most]):
            lines.append(f"  and {len(otherwise[most:])} more")
        for title, names in (
            ("in the recording but not on the rig", self.unmatched_weights),
            ("on the rig but not driven", self.unmatched_sliders),
            ("rotations, which drive no slider", self.rotations),
        ):
            if names:
                lines.append(f"{title}: {first_few(names, len(names) if most is None else most)}")
        return "\n".join(lines)


def match(weights: Sequence[str], sliders: Sequence[str]) -> Match:
    """Find which weights drive which sliders.

    Equal shapes are matched first, whatever their spelling (see `naming`). Then, of what is left:
    one weight for both sides drives each side in full (``browInnerUp`` → ``browInnerUp_L``,
    ``browInnerUp_R``). Two sides drive one slider for both by their mean, not their maximum: the
    mean is right where they agree, closest to both where they do not, and never drives a wink to
    two closed eyes; both sides must be there. No weight drives in two of these ways, so a rig with
    a whole and its halves is not driven twice.

    Args:
        weights: Names in the recording.
        sliders: Names on the rig.

    Raises:
        ParameterError: A name is there twice, or two spellings of one shape leave it open which
            is meant.
    """
    for kind, names in (("recording", weights), ("rig", sliders)):
        if len(set(names)) != len(names):
            twice = next(name for name in names if list(names).count(name) > 1)
            raise ParameterError(f"the {kind} has {twice!r} twice; each needs its own name")
    recorded = _by_shape((n for n in weights if not is_rotation(n)), "recording")
    on_rig = _by_shape((n for n in sliders if not is_rotation(n)), "rig", weights)
    drives: dict[str, Drive] = {}
    used: set[str] = set()
    for shape, names in recorded.items():
        for slider in on_rig.pop(shape, []):
            drives[slider] = Drive((names[0],), (1.0,))
            used.add(shape)
    for whole, parts in wholes():
        if whole in recorded and whole not in used:
            for part in parts:
                for slider in on_rig.pop(part, []):
                    drives[slider] = Drive((recorded[whole][0],), (1.0,))
                    used.add(whole)
        elif whole in on_rig and all(part in recorded and part not in used for part in parts):
            drive = Drive(
                tuple(recorded[part][0] for part in parts), (1 / len(parts),) * len(parts)
            )
            drives.update(dict.fromkeys(on_rig.pop(whole), drive))
            used.update(parts)
    ordered = {slider: drives[slider] for slider in sliders if slider in drives}
    return Match(tuple(weights), tuple(sliders), ordered)


def _by_shape(
    names: Iterable[str], kind: str, preferred: Iterable[str] = ()
) -> dict[str, list[str]]:
    """The names of each shape; a name that no table has is a shape of its own.

    Several nodes of a rig (``face.jawOpen``, ``teeth.jawOpen``) may each have a shape once.
    """
    found: dict[str, dict[str, list[str]]] = {}
    for name in names:
        shape = shape_of(name) or name
        node = name[: max(name.rfind(":"), name.rfind(".")) + 1] if kind == "rig" else ""
        found.setdefault(shape, {}).setdefault(node, []).append(name)
    wanted = set(preferred)
    return {
        shape: [_only(shape, same, kind, wanted) for same in nodes.values()]
        for shape, nodes in found.items()
    }


def _only(shape: str, names: list[str], kind: str, wanted: set[str]) -> str:
    exact = [name for name in names if name in wanted] if len(names) > 1 else names
    if len(exact) != 1:
        raise ParameterError(
            f"the {kind} has {' and '.join(names)}, which are both {shape}; rename or leave out "
            "one of them"
        )
    return exact[0]


def _formula(drive: Drive) -> str:
    return " + ".join(
        name if factor == 1 else f"{factor:g} {name}"
        for name, factor in zip(drive.names, drive.factors, strict=True)
    )


# A performance: recorded weights over time, and its frames on a rig.
#
# How a recorded head is turned: the angles of a take, as rotations about the neck.
#
# ARKit and Live Link Face count yaw to the head's own right, pitch downwards, and roll leaned to
# its own left, in radians. In coordinates of glTF, where a face looks along +Z with +Y up, that
# is
#
#     R = R_y(-yaw) R_x(pitch) R_z(-roll)
#
# The viewer page has the same formula in ``web/viewer/rig/head.ts``.

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


# Named poses on a rig: which sliders they mean, and a performance that goes through them.

Poses = Mapping[str, Mapping[str, float]]

_SHOWN = 8
_MOST_POSED = 1_000_000
_SAME = 1e-6
"""Of a frame: closer to a pose, a frame is that pose."""


class FittedPoses(NamedTuple):
    """Poses by the names of a rig's sliders, and what none of its sliders stands for."""

    poses: dict[str, dict[str, float]]
    unknown: tuple[str, ...]


def fitted_poses(poses: Poses, sliders: Sequence[str]) -> FittedPoses:
    """Poses for a rig: names that it has are its own, others are matched as those of a take.

    Args:
        poses: The weight of each slider by name, of each pose by name.
        sliders: Names on the rig.

    Raises:
        ParameterError: It is not clear which slider a name means, see `match`.
    """
    names, table = _table(poses)
    if set(names) <= set(sliders):
        return FittedPoses({name: dict(own) for name, own in poses.items()}, ())
    found = match(names, sliders)
    rows = found.drive(table).tolist()
    driven = [
        {slider: weight for slider, weight in zip(found.sliders, row, strict=True) if weight}
        for row in rows
    ]
    unknown = (*found.unmatched_weights, *filter(is_rotation, names))
    return FittedPoses(dict(zip(poses, driven, strict=True)), unknown)


def unknown_sliders(unknown: Sequence[str], sliders: Sequence[str]) -> str:
    """A sentence about names that a rig does not have, with the nearest that it has."""
    words = []
    for name in unknown[:_SHOWN]:
        near = nearest_name(name, sliders)
        words.append(f"{name!r} (did you mean {near!r}?)" if near else repr(name))
    return f"the rig has no slider {first_few([*words, *unknown[_SHOWN:]], _SHOWN)}"


def through_poses(
    poses: Poses,
    times: Sequence[float] | None = None,
    *,
    timing: Timing = smoothstep,
    rate: float = 30.0,
    source: str = "",
) -> Performance:
    """A performance that is in each pose at its time, and between two as the timing says.

    Args:
        poses: The weight of each slider by name, of each pose by name, in order.
        times: Seconds of each pose, rising; a second from one to the next by default.
        timing: How far the way from one pose to the next has come, from 0 to 1.
        rate: Frames a second. Each pose is a frame too, wherever its time lies.
        source: Where the poses come from.

    Raises:
        ParameterError: No pose, other times than poses, times that do not rise, or a timing that
            does not lead from 0 to 1.
    """
    names, table = _table(poses)
    when = np.arange(len(table), dtype=np.float64) if times is None else np.array(times, float)
    if not len(table) or when.shape != (len(table),):
        raise ParameterError(f"{len(table)} poses need a time each, found {len(when)}")
    if not np.isfinite(when).all() or (np.diff(when) <= 0).any():
        raise ParameterError(
            f"the times of poses must rise, found {', '.join(f'{t:g}' for t in when)}"
        )
    if not rate > 0 or not np.isfinite(rate):
        raise ParameterError(f"the rate must be frames a second above 0, found {rate}")
    if not np.allclose(timing.at([0.0, 1.0]), [0.0, 1.0]):
        raise ParameterError(
            f"the timing {timing.name} does not lead from one pose to the next; take smoothstep, "
            "minimum-jerk, cosine, linear or keys from 0=0 to 1=1"
        )
    frames = _moments(when, rate)
    before = np.clip(np.searchsorted(when, frames, side="right") - 1, 0, max(len(when) - 2, 0))
    after = np.minimum(before + 1, len(when) - 1)
    length = np.where(after > before, when[after] - when[before], 1.0)
    way = timing.at((frames - when[before]) / length)[:, None]
    weights = table[before] * (1 - way) + table[after] * way
    return Performance(names, frames, weights, rate, source=source)


def _moments(when: NDArray[np.float64], rate: float) -> NDArray[np.float64]:
    """(T,) frames at an even rate from the first time on, and the times themselves."""
    places = (when - when[0]) * rate
    if places[-1] > _MOST_POSED:
        raise ParameterError(
            f"{rate:g} frames a second of {when[-1] - when[0]:g} s are more than "
            f"{_MOST_POSED:,} frames; choose a lower rate"
        )
    even = np.arange(int(places[-1]) + 1)
    beside = np.rint(places[np.abs(places - np.rint(places)) < _SAME]).astype(np.int64)
    return np.union1d(when[0] + np.setdiff1d(even, beside) / rate, when)


def _table(poses: Poses) -> tuple[list[str], NDArray[np.float64]]:
    """The names of all weights, and (poses, names) weights."""
    names = list(dict.fromkeys(name for weights in poses.values() for name in weights))
    rows = [[float(weights.get(name, 0.0)) for name in names] for weights in poses.values()]
    return names, np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
