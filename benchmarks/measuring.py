"""What the benchmarks share: where the real data is, and the time of a task."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

__all__ = ["best_seconds", "data_folder"]


def data_folder() -> Path:
    """The folder of real data: ``ELASTOMORPH_DATA``, or ``../shared/data`` beside the checkout."""
    named = os.environ.get("ELASTOMORPH_DATA")
    return Path(named) if named else Path(__file__).resolve().parents[2] / "shared" / "data"


def best_seconds(task: Callable[[], object], repeats: int = 7) -> float:
    """Shortest of several runs."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        task()
        times.append(time.perf_counter() - start)
    return min(times)
