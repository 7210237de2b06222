"""What is being done, and how long all of it will still take."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

StageSay = Callable[[str, float], None]
"""Called by a stage with what it does and the part of it that is done, from 0 to 1."""

_LEAST = 5.0  # seconds of work before anything can be said of the rest


class Progress:
    """Follows a work of many stages.

    Of a kind of stage that was made before, here or in an earlier run, it is known what one takes.
    Of another, what was expected is corrected by how far off the expectations of the others were.

    Args:
        say: Told what is being done, with the time left where that can be said.
        expected: Stage → seconds that it takes on some machine; the kind of a stage is what its
            name has before the first "/".
        clock: Seconds.
    """

    def __init__(
        self,
        say: Callable[[str], None],
        expected: Mapping[str, float],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._say = say
        self._expected = dict(expected)
        self._clock = clock
        self._took: dict[str, float] = {}
        self._worked = 0.0

    def begun(self, stage: str) -> StageSay:
        """To be told what a stage does, from now on."""
        start = self._clock()

        def say(text: str, part: float) -> None:
            left = self._left(stage, part, self._clock() - start)
            self._say(text if left is None else f"{text} · {_in_words(left)} left")

        return say

    def done(self, stage: str, seconds: float, *, anew: bool = True) -> None:
        """A stage is there, and took so long to make."""
        self._took[stage] = seconds
        self._worked += seconds if anew else 0.0

    def _left(self, stage: str, part: float, elapsed: float) -> float | None:
        """Seconds until all stages are there; None where too little is known."""
        if self._worked + elapsed < _LEAST and not self._took:
            return None
        slower = self._slower(stage, part, elapsed)
        total = 0.0
        for name, expected in self._expected.items():
            if name in self._took:
                continue
            kind = self._of_kind(name)
            whole = expected * slower if kind is None else kind
            if name != stage:
                total += whole
            elif part > 0.1:
                total += elapsed * (1 - part) / part
            else:
                total += max(0.0, whole - elapsed)
        return total

    def _of_kind(self, stage: str) -> float | None:
        """Seconds that stages of this kind took, against what was expected of each."""
        kind = stage.partition("/")[0]
        same = [name for name in self._took if name.partition("/")[0] == kind]
        expected = sum(self._expected.get(name, 0.0) for name in same)
        if not same or not expected:
            return None
        return self._expected[stage] * sum(self._took[name] for name in same) / expected

    def _slower(self, stage: str, part: float, elapsed: float) -> float:
        """How many times longer than expected the work has taken so far."""
        known = [name for name in self._took if name in self._expected]
        took = sum(self._took[name] for name in known) + elapsed
        expected = sum(self._expected[name] for name in known) + part * self._expected[stage]
        return took / expected if expected > 0 else 1.0


def _in_words(seconds: float) -> str:
    if seconds < 50:
        return f"about {max(10, 10 * round(seconds / 10))} s"
    if seconds < 5400:
        return f"about {max(1, round(seconds / 60))} min"
    return f"about {seconds / 3600:.1f} h"
