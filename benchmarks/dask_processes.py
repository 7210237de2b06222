"""A Dask scheduler and workers as separate processes of this machine, to be killed."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import psutil

__all__ = ["Separate", "kill_all", "separate", "workers_below"]

_START = 60.0


@dataclass
class Separate:
    """A scheduler and the nannies of its workers, on the loopback.

    Attributes:
        scheduler: The scheduler's process.
        nannies: One process that starts all workers, and starts those anew that end.
        address: Of the scheduler.
    """

    scheduler: subprocess.Popen[bytes]
    nannies: subprocess.Popen[bytes]
    address: str

    def workers(self) -> list[psutil.Process]:
        """The processes that make units at the moment."""
        return workers_below(self.nannies.pid)


@contextmanager
def separate(workers: int = 2) -> Iterator[Separate]:
    """A scheduler and workers as their own commands start them; ended with all they started."""
    with TemporaryDirectory() as folder:
        told = Path(folder) / "scheduler.json"
        scheduler = _started(
            *("scheduler", "--host", "127.0.0.1", "--port", "0"),
            *("--dashboard-address", "127.0.0.1:0", "--scheduler-file", str(told)),
        )
        nannies = _started(
            *("worker", "--scheduler-file", str(told), "--nworkers", str(workers)),
            *("--host", "127.0.0.1", "--nthreads", "1", "--local-directory", folder),
        )
        try:
            yield Separate(scheduler, nannies, _address(told))
        finally:
            kill_all(nannies)
            kill_all(scheduler)


def workers_below(number: int) -> list[psutil.Process]:
    """The worker processes that a process has started."""
    with suppress(psutil.NoSuchProcess):
        children = psutil.Process(number).children(recursive=True)
        return [child for child in children if "spawn_main" in " ".join(_words(child))]
    return []


def kill_all(process: subprocess.Popen[bytes]) -> None:
    """Kill a process and what it started, without a chance to clean up."""
    with suppress(psutil.NoSuchProcess):
        for child in psutil.Process(process.pid).children(recursive=True):
            with suppress(psutil.NoSuchProcess):
                child.kill()
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _started(verb: str, *words: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, "-m", f"distributed.cli.dask_{verb}", *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def _address(told: Path) -> str:
    limit = time.monotonic() + _START
    while time.monotonic() < limit:
        with suppress(OSError, ValueError):
            return str(json.loads(told.read_text())["address"])
        time.sleep(0.05)
    raise SystemExit(f"no Dask scheduler started within {_START:.0f} s")


def _words(process: psutil.Process) -> list[str]:
    with suppress(psutil.Error):
        return list(process.cmdline())
    return []
