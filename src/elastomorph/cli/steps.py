"""What a long run is doing, step by step: lines with the time, on a terminal or in a log."""

from __future__ import annotations

import re
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from elastomorph.errors import ElastomorphWarning

__all__ = ["steps"]

_COUNTED = re.compile(r"\b\d+ of \d+$")
_GAP = 4.0
"""Seconds between two counted steps."""


@contextmanager
def steps(quiet: bool = False) -> Iterator[Callable[[str], None]]:
    """A function that prints a step with the seconds since the start, on standard error.

    Of steps that count, as in "3 of 57", only one every few seconds is printed. Warnings follow
    at the end, each once, as plain sentences.

    Args:
        quiet: Print warnings only.
    """
    from rich.console import Console

    console = Console(stderr=True)
    start = time.perf_counter()
    counted_at = -_GAP

    def say(step: str) -> None:
        nonlocal counted_at
        now = time.perf_counter() - start
        if quiet:
            return
        if _COUNTED.search(step):
            if now < counted_at + _GAP:
                return
            counted_at = now
        console.print(f"{now:6.1f} s  {step}", markup=False, highlight=False, soft_wrap=True)

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", ElastomorphWarning)
        yield say
    for message in dict.fromkeys(str(warning.message) for warning in caught):
        console.print(f"warning: {message}", markup=False, highlight=False, soft_wrap=True)
