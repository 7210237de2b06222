"""The movements in a recorded take: from rest to an apex (onset) and back (offset), each judged."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.curves import CurveNetwork
from elastomorph.errors import MeshError, ParameterError
from elastomorph.evaluation.confidence import Confidence, share_words
from elastomorph.evaluation.evaluation import AnyMethod, evaluate
from elastomorph.evaluation.results import Evaluation
from elastomorph.evaluation.summary import MethodSummary, mean_summaries
from elastomorph.model.geometry import largest_distance
from elastomorph.model.sequence import MeshSequence


@dataclass(frozen=True)
class Movement:
    """A stretch of a take in which the face goes from one pose to another.

    Attributes:
        start: First frame.
        stop: Last frame, inclusive, as in `MeshSequence.part`.
        kind: ``onset``, away from rest, or ``offset``, back to it.
    """

    start: int
    stop: int
    kind: Literal["onset", "offset"]


def resting_pose(frames: ArrayLike) -> NDArray[np.float64]:
    """The pose a take keeps coming back to.

    The median over all frames, then twice the median over the half of the frames closest to it,
    so that a pose held for less than about half of the take does not count.

    Args:
        frames: (T, N, 3) positions of markers or vertices.

    Returns:
        (N, 3) positions.
    """
    moving = _as_take(frames)
    rest = np.median(moving, axis=0)
    for _ in range(2):
        distance = _rms(moving, rest)
        rest = np.median(moving[distance <= np.median(distance)], axis=0)
    return rest


def activity(frames: ArrayLike, rest: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T,) RMS distance of (T, N, 3) frames from a (N, 3) pose, as a fraction of D of the pose."""
    moving = _as_take(frames)
    diameter = largest_distance(rest)
    if not diameter > 0:
        raise MeshError("all markers of the resting pose are at one place: its diameter D is 0")
    return _rms(moving, rest) / diameter


def find_movements(
    frames: ArrayLike,
    *,
    rest: NDArray[np.float64] | None = None,
    least_rise: float = 0.005,
    edge: float = 0.05,
    turn: float = 0.25,
    smoothing: float = 3.0,
    reach: int = 30,
    shortest: int = 6,
) -> list[Movement]:
    """Onsets and offsets in a take, in the order they occur.

    The activity is smoothed over time. Its *rest level* is its median over the quieter half of
    the take, and an excursion is a stretch above the rest level by `least_rise`. The onset of an
    excursion leads from the last frame at which the activity is below `edge` of the way from the
    quietest frame shortly before to the peak, to the first frame above 1 - `edge` of it; the
    offset is the mirror image. An excursion cut off by an end of the take has no onset, or no
    offset.

    In speech, excursions run together. Where an onset or offset turns back by more than `turn` of
    its rise, from lowest to highest, it is split at both ends of the turn, and each part, the turn
    too, is a movement if it reaches `least_rise`; so no movement found turns back farther.

    Args:
        frames: (T, N, 3) positions of markers or vertices, rigid head motion removed, at a
            constant rate.
        rest: (N, 3) the pose movements start from; `resting_pose` by default.
        least_rise: How far above the rest level a movement must reach, as a fraction of D: the
            RMS distance of the markers. 0.005 is 1 mm on a face of 20 cm.
        edge: Share of the rise cut off at either end, from 0 to below 0.5: rest and apex are
            never quite still, and with 0 a movement holds on to the last of either.
        turn: Share of its rise, above 0, by which a movement may turn back; 1 to split none.
        smoothing: Standard deviation of the Gaussian, in frames; 0 for none.
        reach: How many frames before and after an excursion its quietest frame is looked for:
            about half a second, lest a slow drift of the rest counts as movement.
        shortest: Movements of fewer frames are left out.

    Raises:
        MeshError: Frames are not finite (T, N, 3) numbers.
        ParameterError: A setting is out of its range.
    """
    _require_settings(least_rise, edge, turn, smoothing, reach, shortest)
    moving = _as_take(frames)
    level = activity(moving, resting_pose(moving) if rest is None else rest)
    if smoothing > 0:
        from scipy.ndimage import gaussian_filter1d

        level = gaussian_filter1d(level, smoothing, mode="nearest")
    found = [
        _trimmed(level, *part, edge)
        for stretch in _stretches(level, least_rise, reach)
        for part in _one_way(level, stretch, turn)
        if abs(level[part[1]] - level[part[0]]) >= least_rise
    ]
    return [move for move in found if move.stop - move.start + 1 >= shortest]


def _require_settings(
    least_rise: float, edge: float, turn: float, smoothing: float, reach: int, shortest: int
) -> None:
    for name, value, allowed, expected in (
        ("least_rise", least_rise, least_rise > 0, "above 0"),
        ("edge", edge, 0 <= edge < 0.5, "from 0 to below 0.5"),
        ("turn", turn, 0 < turn <= 1, "above 0 and at most 1"),
        ("smoothing", smoothing, smoothing >= 0, "0 or more"),
        ("reach", reach, reach >= 1, "1 or more"),
        ("shortest", shortest, shortest >= 2, "2 or more"),
    ):
        if not allowed:
            raise ParameterError(f"{name} must be {expected}, found {value}")


def _stretches(
    level: NDArray[np.float64], least_rise: float, reach: int
) -> Iterator[tuple[int, int]]:
    """From the quietest frame near an excursion to its peak, and from there to the next such."""
    rest_level = float(np.median(level[level <= np.median(level)]))
    excursions = _runs(level > rest_level + least_rise)
    for number, (first, stop) in enumerate(excursions):
        quiet_from = max(first - reach, excursions[number - 1][1] if number else 0)
        following = excursions[number + 1][0] if number + 1 < len(excursions) else len(level)
        quiet_to = min(stop + reach, following)
        peak = first + int(np.argmax(level[first:stop]))
        if first > quiet_from:
            yield quiet_from + int(np.argmin(level[quiet_from:first])), peak
        if stop < quiet_to:
            yield peak, stop + int(np.argmin(level[stop:quiet_to]))


def _one_way(
    level: NDArray[np.float64], stretch: tuple[int, int], turn: float
) -> list[tuple[int, int]]:
    """First and last frames of the parts of a stretch that turn back by at most a share each."""
    parts, waiting = [], [stretch]
    while waiting:
        start, stop = waiting.pop()
        own = level[start : stop + 1]
        rising = own if own[-1] > own[0] else -own
        highest = np.maximum.accumulate(rising)
        back = int(np.argmax(highest - rising))
        if highest[back] - rising[back] <= turn * (rising[-1] - rising[0]):
            parts.append((start, stop))
            continue
        ahead = int(np.argmax(rising[: back + 1]))
        turns = (start, start + ahead, start + back, stop)
        waiting += reversed(list(pairwise(turns)))
    return parts


def _trimmed(level: NDArray[np.float64], start: int, stop: int, edge: float) -> Movement:
    """The movement from frame to frame, less a share of its rise at both ends."""
    own = level[start : stop + 1]
    onset = own[-1] > own[0]
    rising = own if onset else own[::-1]
    base, peak = rising[0], rising[-1]
    high = int(np.argmax(rising >= peak - edge * (peak - base)))
    low = int(np.flatnonzero(rising[:high] <= base + edge * (peak - base))[-1])
    if onset:
        return Movement(start + low, start + high, "onset")
    return Movement(stop - high, stop - low, "offset")


def _runs(inside: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Start and stop (exclusive) of each run of true values."""
    steps = np.diff(np.concatenate([[0], inside.astype(np.int8), [0]]))
    starts, stops = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    return [(int(start), int(stop)) for start, stop in zip(starts, stops, strict=True)]


def _rms(moving: NDArray[np.float64], pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """(T,) root of the mean squared distance over the markers."""
    offsets = moving - pose
    squared: NDArray[np.float64] = np.einsum("tni,tni->t", offsets, offsets) / moving.shape[1]
    return np.sqrt(squared)


def _as_take(frames: ArrayLike) -> NDArray[np.float64]:
    moving = np.asarray(frames, dtype=np.float64)
    if moving.ndim != 3 or moving.shape[2] != 3 or 0 in moving.shape:
        raise MeshError(f"a take must have shape (T, N, 3), found {moving.shape}")
    if not np.isfinite(moving).all():
        frame = int(np.argmin(np.isfinite(moving).all(axis=(1, 2))))
        raise MeshError(f"frame {frame} of the take has coordinates that are not finite")
    return moving


@dataclass(frozen=True, eq=False)
class JudgedMovement:
    """One movement and how the methods did on it."""

    movement: Movement  # Where it is in the take
    evaluation: Evaluation  # The methods compared with it


def evaluate_movements(
    take: MeshSequence,
    curves: CurveNetwork,
    methods: Callable[..., Sequence[AnyMethod] | Mapping[str, AnyMethod]],
    *,
    edge: float = 0.05,
    confidence: Confidence | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> list[JudgedMovement]:
    """Find the movements of a take without rigid motion of the head, and evaluate methods on each.

    `methods` gives those for one movement: scanned in-betweens differ from one to the next. Where
    there is a confidence it is called with that of the movement, too.
    """
    movements = find_movements(take.frames, edge=edge)
    if not movements:
        raise ParameterError(
            "no movement was found: from rest to an apex and back, of at least 0.5 % of D"
        )
    judged = []
    for number, move in enumerate(movements, start=1):
        progress(f"{move.kind} {move.start}-{move.stop} ({number} of {len(movements)})")
        part = take.part(move.start, move.stop)
        mask = None if confidence is None else confidence.part(move.start, move.stop)
        how = methods(part) if mask is None else methods(part, mask)
        judged.append(JudgedMovement(move, evaluate(part, how, curves, confidence=mask)))
    return judged


def coverage_of(judged: Sequence[JudgedMovement]) -> str:
    """How much of the vertices count in the movements, in a sentence; empty where all do."""
    masked = [one for one in judged if one.evaluation.confidence is not None]
    if not masked:
        return ""
    shares = [one.evaluation.covered for one in masked]
    least = min(masked, key=lambda one: one.evaluation.covered)
    where = f"{least.movement.kind} {least.movement.start}-{least.movement.stop}"
    return (
        f"{share_words(float(np.mean(shares)))} of the vertices count in the movements, "
        f"{share_words(min(shares))} in {where}"
    )


def mean_lines(judged: Sequence[JudgedMovement]) -> dict[str, list[MethodSummary]]:
    """The mean of each error over the onsets, the offsets and all movements, by title."""
    groups = {
        "onsets": [one for one in judged if one.movement.kind == "onset"],
        "offsets": [one for one in judged if one.movement.kind == "offset"],
        "movements": list(judged),
    }
    return {
        f"Mean over {len(group)} {kind}": mean_summaries([one.evaluation for one in group])
        for kind, group in groups.items()
        if group
    }
