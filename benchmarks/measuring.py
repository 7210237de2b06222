"""What the benchmarks share: where the real data is, the time of a task, and a busy machine."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from elastomorph.blas_threads import usable_cores

__all__ = ["best_seconds", "busy_cores", "data_folder"]

# It ends when its input does, so that it cannot outlive the benchmark, however that ends.
_SPIN = """
import os, sys, threading
threading.Thread(target=lambda: (sys.stdin.read(), os._exit(0)), daemon=True).start()
while True:
    sum(range(100_000))
"""


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


@contextmanager
def busy_cores() -> Iterator[None]:
    """Another process for each core of this one, which does nothing but keep it busy."""
    with ExitStack() as stack:
        for _ in range(usable_cores()):
            process = subprocess.Popen([sys.executable, "-c", _SPIN], stdin=subprocess.PIPE)
            stack.callback(process.wait)
            assert process.stdin is not None
            stack.callback(process.stdin.close)
        time.sleep(1)  # until all of them have started
        yield
