"""Commands of the package in processes of their own, with their time and memory."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from dataclasses import dataclass

__all__ = ["Run", "ran"]


@dataclass(frozen=True)
class Run:
    """What a command took.

    Attributes:
        seconds: Of the clock.
        processor: Seconds of all cores together.
        gigabytes: The most memory at any time.
    """

    seconds: float
    processor: float
    gigabytes: float

    def __add__(self, other: Run) -> Run:
        """One after the other."""
        return Run(
            self.seconds + other.seconds,
            self.processor + other.processor,
            max(self.gigabytes, other.gigabytes),
        )


def ran(*arguments: object) -> Run:
    """Run ``elastomorph`` with these arguments.

    Raises:
        SystemExit: It ended with an error, which it has printed.
    """
    start = time.perf_counter()
    command = [sys.executable, "-m", "elastomorph", *map(str, arguments)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"{' '.join(command[2:])} ended with status {process.returncode}")
    unit = 1 if sys.platform == "darwin" else 1024  # of ru_maxrss, in bytes
    return Run(
        time.perf_counter() - start,
        used.ru_utime + used.ru_stime,
        used.ru_maxrss * unit / 1e9,
    )
