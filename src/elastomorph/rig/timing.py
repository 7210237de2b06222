"""Timings: when a performance is where on a path, kept apart from the path.

A path says *where* a face goes, a timing *when* it is there: t′ = timing(t), with t from 0 to 1
over a clip. It is applied where a path is sampled, animated or exported and is never mixed into
the stored path:

    morph.at(timing.minimum_jerk.at(times))          # or timed(morph, timing.minimum_jerk, times)
    rig.pose({"jawOpen": timing.cosine.at(0.3)})     # a timing of a weight

Before its clip a timing holds its first value, after it the last.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from elastomorph.errors import ParameterError
from elastomorph.model.bend_curve import as_times
from elastomorph.model.morph import Morph

__all__ = [
    "NAMES",
    "Law",
    "Timing",
    "blink",
    "by_name",
    "cosine",
    "from_keys",
    "gompertz",
    "linear",
    "minimum_jerk",
    "smoothstep",
    "timed",
]

Law = Callable[[NDArray[np.float64]], ArrayLike]
"""From times in [0, 1], shape (T,), to as many values."""

_MOST_GOMPERTZ = 50.0


@dataclass(frozen=True, eq=False)
class Timing:
    """A named time law t′(t) over a clip from t = 0 to t = 1.

    Those of this module stay within [0, 1]; a law of your own may leave it, to anticipate or to
    overshoot: paths go straight on there.

    Attributes:
        name: For captions; `by_name` makes the same timing of the names of this module.
        law: The function, called with (T,) times within [0, 1].
    """

    name: str
    law: Law = field(repr=False)

    def at(self, times: ArrayLike) -> NDArray[np.float64]:
        """The value at one time or at several.

        Args:
            times: A number, or (T,) numbers; 0 is the start of the clip, 1 its end.

        Returns:
            Float64 of the shape of ``times``.

        Raises:
            ParameterError: A time is not a finite number, or the law does not answer with one
                finite number for each time.
        """
        t = as_times(times)
        moments = np.clip(np.atleast_1d(t), 0.0, 1.0)
        values = np.asarray(self.law(moments), dtype=np.float64)
        if values.shape != moments.shape:
            raise ParameterError(
                f"timing {self.name!r} must give {moments.size} values for {moments.size} times, "
                f"found shape {values.shape}"
            )
        if not np.isfinite(values).all():
            bad = moments[~np.isfinite(values)][0]
            raise ParameterError(f"timing {self.name!r} has no finite value at t = {bad:g}")
        return values.reshape(t.shape)

    def __call__(self, times: ArrayLike) -> NDArray[np.float64]:
        """The same as `at`."""
        return self.at(times)


def timed(morph: Morph, timing: Timing | str | Law, times: ArrayLike) -> NDArray[np.float64]:
    """Vertex positions of a path played with a timing.

    Args:
        morph: The path.
        timing: A timing, its name, or a function from (T,) times to as many values.
        times: (T,) numbers; 0 is the start of the clip, 1 its end.

    Returns:
        (T, V, 3) float64.

    Raises:
        ParameterError: The timing is unknown, or a time is not a finite number.
    """
    return morph.at(np.atleast_1d(_as_timing(timing).at(times)))


def gompertz(shape: float = 3.0) -> Timing:
    """A quick rise that settles slowly: the Gompertz function exp(-exp(s(1 - 2t))), from 0 to 1.

    Steepest at t = ½, where it is still below half of the way. Towards s = 0 it is linear.

    Args:
        shape: s, above 0 and at most 50; the larger, the steeper.

    Raises:
        ParameterError: The shape is out of its range.
    """
    s = float(shape)
    if not 0 < s <= _MOST_GOMPERTZ:
        raise ParameterError(
            f"the shape of gompertz must be above 0 and at most {_MOST_GOMPERTZ:g}, found {shape}"
        )

    def law(t: NDArray[np.float64]) -> NDArray[np.float64]:
        # (G(t) - G(0)) / (G(1) - G(0)) with G = exp(-A), A = exp(s(1 - 2t)), is
        # exp(A(1) - A(t)) · (1 - exp(A(t) - A(0))) / (1 - exp(A(1) - A(0))): written in the
        # differences of A, so that neither a small nor a large s loses digits.
        risen = np.expm1(np.exp(s) * np.expm1(-2.0 * s * t))
        all_risen = np.expm1(np.exp(s) * np.expm1(-2.0 * s))
        return np.asarray(np.exp(np.exp(-s) - np.exp(s - 2.0 * s * t)) * risen / all_risen)

    return Timing(f"gompertz:{s!r}", law)


def blink(closing: float = 0.3, closed: float = 0.0) -> Timing:
    """A lid that closes fast and opens slowly: from 0 to 1 and back to 0 over the clip.

    Closing and opening are of minimum jerk, so that velocity and acceleration are zero where they
    meet. For a weight such as ``eyeBlink_L``, not to play one path from end to end.

    Args:
        closing: Share of the clip until the lid is closed, within (0, 1).
        closed: Share of the clip in which it stays closed, 0 or more; the rest is for opening.

    Raises:
        ParameterError: A share is out of its range, or nothing is left for opening.
    """
    down, still = float(closing), float(closed)
    if not (down > 0 and still >= 0 and down + still < 1):
        raise ParameterError(
            "a blink needs closing above 0, closed of 0 or more, and together below 1, "
            f"found {closing} and {closed}"
        )

    def law(t: NDArray[np.float64]) -> NDArray[np.float64]:
        opening = np.minimum((1.0 - t) / (1.0 - down - still), 1.0)
        return _minimum_jerk(np.where(t < down, t / down, opening))

    return Timing(f"blink:{down!r}" + (f":{still!r}" if still else ""), law)


def from_keys(keys: Iterable[tuple[float, float]]) -> Timing:
    """A timing through keys: smooth, and rising or falling just where the keys do (PCHIP).

    Between two keys the value never leaves their range, so keys that rise give a timing that
    rises. Before the first key and after the last the value stays.

    Args:
        keys: Pairs (t, value), two or more, at different t within [0, 1], in any order.

    Raises:
        ParameterError: Fewer than two keys, a t out of its range or twice, or no finite value.
    """
    try:
        pairs = sorted((float(time), float(value)) for time, value in keys)
    except (TypeError, ValueError):
        raise ParameterError("keys must be pairs of numbers (t, value)") from None
    if len(pairs) < 2:
        raise ParameterError(f"a timing needs two keys or more, found {len(pairs)}")
    times, values = np.array(pairs).T
    if not np.isfinite(values).all():
        raise ParameterError("the values of keys must be finite numbers")
    if not (times[0] >= 0 and times[-1] <= 1 and (np.diff(times) > 0).all()):
        raise ParameterError(
            "keys must be at different t from 0 to 1, found "
            + ", ".join(f"{time:g}" for time in times)
        )
    from scipy.interpolate import PchipInterpolator

    with np.errstate(over="ignore"):  # harmonic means of slopes near 0, which come out as 0
        curve = PchipInterpolator(times, values)

    def law(t: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(curve(np.clip(t, times[0], times[-1])))

    return Timing("keys:" + ",".join(f"{time!r}={value!r}" for time, value in pairs), law)


def by_name(text: str) -> Timing:
    """The timing that a text names.

    Args:
        text: ``linear``, ``smoothstep``, ``minimum-jerk``, ``cosine``, ``gompertz[:shape]``,
            ``blink[:closing[:closed]]`` or ``keys:0=0,0.3=0.8,1=1``.

    Raises:
        ParameterError: The text is not understood, or a number is out of its range.
    """
    name, _, rest = text.strip().partition(":")
    name = name.strip().lower().replace("_", "-")
    if name == "keys":
        return from_keys(_keys(text, rest))
    numbers = [_number(text, word) for word in rest.split(":")] if rest else []
    fixed = {timing.name: timing for timing in _FIXED}.get(name)
    if fixed is not None and not numbers:
        return fixed
    if name == "gompertz" and len(numbers) <= 1:
        return gompertz(*numbers)
    if name == "blink" and len(numbers) <= 2:
        return blink(*numbers)
    if name in NAMES:
        raise ParameterError(f"timing {text!r}: {name} does not have so many numbers")
    raise ParameterError(
        f"timing {text!r} is unknown; expected one of {', '.join(NAMES)}, as in minimum-jerk, "
        "gompertz:3, blink:0.3 or keys:0=0,0.3=0.8,1=1"
    )


def _linear(t: NDArray[np.float64]) -> NDArray[np.float64]:
    return t


def _smoothstep(t: NDArray[np.float64]) -> NDArray[np.float64]:
    return t * t * (3.0 - 2.0 * t)


def _minimum_jerk(t: NDArray[np.float64]) -> NDArray[np.float64]:
    return t**3 * (10.0 + t * (6.0 * t - 15.0))


def _cosine(t: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(np.sin(0.5 * np.pi * t) ** 2)


linear = Timing("linear", _linear)
"""t: at constant pace."""

smoothstep = Timing("smoothstep", _smoothstep)
"""3t² - 2t³: from rest to rest with the least ∫ (acceleration)² dt."""

minimum_jerk = Timing("minimum-jerk", _minimum_jerk)
"""10t³ - 15t⁴ + 6t⁵: from rest to rest, without acceleration at the ends, with the least
∫ (jerk)² dt (Flash and Hogan, J. Neurosci. 5(7), 1985)."""

cosine = Timing("cosine", _cosine)
"""(1 - cos πt)/2: half a swing of a pendulum."""

_FIXED = (linear, smoothstep, minimum_jerk, cosine)
NAMES = (*(timing.name for timing in _FIXED), "gompertz", "blink", "keys")
"""What `by_name` knows."""


def _as_timing(timing: Timing | str | Law) -> Timing:
    if isinstance(timing, Timing):
        return timing
    if isinstance(timing, str):
        return by_name(timing)
    if callable(timing):
        return Timing(getattr(timing, "__name__", "own"), timing)
    raise ParameterError(f"a timing is a Timing, its name or a function, found {timing!r}")


def _keys(text: str, words: str) -> list[tuple[float, float]]:
    pairs = [word.partition("=") for word in words.split(",")]
    return [(_number(text, time), _number(text, value)) for time, _, value in pairs]


def _number(text: str, word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise ParameterError(f"timing {text!r}: expected a number, found {word!r}") from None
