"""Data sets whose makers are killed at random moments, compared with one that nobody disturbed.

    python benchmarks/farm_kills.py --times 50

A data set is made once by a single process. Then the same command has it made by processes of this
machine, or by a Dask scheduler and workers of their own, and what makes it is killed, without a
chance to clean up, at moments drawn from the whole run. Where that ends the command, it is given
again, until the data set is finished.

All the while somebody reads: a file that is there, at any time, must be, byte by byte, the one of
the undisturbed data set, or it counts as half; and once a unit is in the manifest none of its files
may be written again, or it counts as made twice.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

import psutil

from dask_processes import Separate, kill_all, separate, workers_below

sys.path.append(str(Path(__file__).parents[1] / "tests"))
from small_head import rig_file

__all__ = ["KINDS", "Found", "Watch", "contents", "tried"]

_UNITS = 24
_FACES = 1024  # In a unit of the small head
_STARTING, _MAKING = 4.0, 2.5  # Seconds from which moments are drawn
_LIMIT = 120.0


@dataclass
class Found:
    """What the kills of one kind left.

    Attributes:
        moments: Units that were finished at each kill.
        ended: Kills that ended the command.
        wordless: Commands that ended otherwise than with one sentence, where they could speak.
        twice: Files of finished units that were written again.
        half: Files that were seen and were not whole.
        sets: Data sets finished.
        equal: Those equal to the undisturbed one, file by file.
        left: Processes and temporary files left behind.
    """

    moments: list[int] = field(default_factory=list)
    ended: int = 0
    wordless: list[str] = field(default_factory=list)
    twice: int = 0
    half: int = 0
    sets: int = 0
    equal: int = 0
    left: int = 0

    @property
    def whole(self) -> bool:
        """Whether everything was as it must be."""
        faults = len(self.wordless) + self.twice + self.half + self.left
        return not faults and self.equal == self.sets > 0


class Watch(threading.Thread):
    """Reads a data set while it is made, and compares with the files it must have."""

    def __init__(self, folder: Path, like: dict[str, bytes]) -> None:
        super().__init__(daemon=True)
        self.folder, self.like = folder, like
        self.half: set[str] = set()
        self.twice: set[str] = set()
        self._finished: set[str] = set()
        self._seen: dict[str, tuple[int, int]] = {}
        self._over = threading.Event()

    def run(self) -> None:
        """Look until `stop`."""
        while not self._over.wait(0.02):
            self.look()

    def stop(self) -> None:
        """Look for the last time."""
        self._over.set()
        self.join()
        self.look()

    def look(self) -> None:
        """Look at every file once, at the manifest first: what it names is written by then."""
        finished = set(_units(self.folder))
        for name, content in self.like.items():
            file = self.folder / name
            with suppress(FileNotFoundError):
                now = file.stat()
                stamp = now.st_ino, now.st_mtime_ns
                if self._seen.get(name) == stamp:
                    continue
                if name in self._seen and name.split("/c.")[1].split(".")[0] in self._finished:
                    self.twice.add(name)
                if file.read_bytes() != content:
                    self.half.add(name)
                self._seen[name] = stamp
        self._finished = finished


class Command:
    """``elastomorph farm``, running."""

    def __init__(self, output: Path, scheduler: str, units: int = _UNITS) -> None:
        self.output = output
        words = ("farm", str(rig_file()), "--vertices", "int16", "--faces", str(units * _FACES))
        self.process = subprocess.Popen(
            [sys.executable, "-m", "elastomorph", *words]
            + ["--scheduler", scheduler, "-o", str(output)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )

    def reaches_moment(self, chance: random.Random) -> bool:
        """Wait for a random moment of the run; False where it is over by then.

        One moment in five is while it starts, the others are from its next unit on.
        """
        before = len(_units(self.output))
        if chance.random() < 0.2:
            return not self.is_over(_STARTING * chance.random())
        while len(_units(self.output)) == before:
            if self.is_over(0.02):
                return False
        return not self.is_over(_MAKING * chance.random())

    def is_over(self, seconds: float) -> bool:
        """Wait some time for its end."""
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(seconds)
        return self.process.returncode is not None

    def end(self) -> str:
        """What it said, when it is over; nothing where it was killed."""
        return self.process.communicate(timeout=_LIMIT)[1].strip()

    def left(self) -> int:
        """How many processes of its session are still there a while after its end."""
        limit = time.monotonic() + 20
        while found := _session(self.process.pid):
            if time.monotonic() > limit:
                return found
            time.sleep(0.1)
        return 0


Kill = Callable[[Command, random.Random], bool]
"""Kills something that serves a command; False where there is nothing to kill."""
Serve = Callable[[], AbstractContextManager[tuple[str, Kill]]]
"""What serves commands, as ``--scheduler`` has it, and a way to kill it."""


@contextmanager
def _here(kill: Kill) -> Iterator[tuple[str, Kill]]:
    yield "local", kill


@contextmanager
def _elsewhere(kill: Callable[[Separate, random.Random], bool]) -> Iterator[tuple[str, Kill]]:
    with separate() as machines:
        yield machines.address, lambda _, chance: kill(machines, chance)


def _command(command: Command, _: random.Random) -> bool:
    command.process.kill()
    return True


def _scheduler(machines: Separate, _: random.Random) -> bool:
    if machines.scheduler.poll() is not None:
        return False
    kill_all(machines.scheduler)
    return True


def _both(machines: Separate, chance: random.Random) -> bool:
    return _one_of(machines.workers(), chance) and _scheduler(machines, chance)


def _one_of(workers: list[psutil.Process], chance: random.Random) -> bool:
    if workers:
        with suppress(psutil.NoSuchProcess):
            chance.choice(workers).kill()
            return True
    return False


KINDS: dict[str, tuple[float, Serve]] = {
    "a worker, local": (
        0.28,
        lambda: _here(lambda own, chance: _one_of(workers_below(own.process.pid), chance)),
    ),
    "a worker elsewhere": (
        0.16,
        lambda: _elsewhere(lambda own, chance: _one_of(own.workers(), chance)),
    ),
    "the scheduler": (0.2, lambda: _elsewhere(_scheduler)),
    "scheduler and worker": (0.16, lambda: _elsewhere(_both)),
    "the command itself": (0.2, lambda: _here(_command)),
}
"""What is killed: its share of all kills, and what serves a command."""


def tried(
    serve: Serve, times: int, chance: random.Random, like: dict[str, bytes], units: int = _UNITS
) -> Found:
    """Kill again and again what makes data sets, and look at them.

    Args:
        serve: Of `KINDS`.
        times: Kills.
        chance: Draws moments, and which worker is killed.
        like: The files that a data set must have.
        units: Of a data set.
    """
    found = Found()
    while len(found.moments) < times:
        with TemporaryDirectory() as place:
            output = Path(place) / "faces.zarr"
            watch = Watch(output, like)
            watch.start()
            while not _given(serve, output, times, chance, found, units):
                pass
            watch.stop()
            found.sets += 1
            found.equal += contents(output) == like
            found.half += len(watch.half)
            found.twice += len(watch.twice)
            found.left += len(list(output.rglob("*.partial")))
    return found


def _given(
    serve: Serve, output: Path, times: int, chance: random.Random, found: Found, units: int
) -> bool:
    """Give the command once, with kills; whether it finished the data set."""
    with serve() as (scheduler, kill):
        command, before = Command(output, scheduler, units), len(found.moments)
        try:
            while len(found.moments) < times and command.reaches_moment(chance):
                finished = len(_units(output))
                if kill(command, chance):
                    found.moments.append(finished)
            said, status = command.end(), command.process.returncode
            found.left += command.left()
        finally:
            kill_all(command.process)
    if status and len(found.moments) == before:
        raise SystemExit(f"a command that nobody disturbed ended with {status}: {said}")
    if status:
        found.ended += 1
        spoke = status == 1 and said.startswith("error: ") and "\n" not in said
        if status != -signal.SIGKILL and not spoke:
            found.wordless.append(said)
    return not status


def _units(folder: Path) -> list[str]:
    """The units that are in the manifest."""
    with suppress(FileNotFoundError):
        names = [path.name for path in (folder / "manifest").iterdir()]
        return [n.split(".")[1] for n in names if n[:2] == "c." and not n.endswith(".partial")]
    return []


def contents(folder: Path) -> dict[str, bytes]:
    """The files of the units of a data set, by name."""
    files = [path for path in folder.rglob("c.*") if path.is_file()]
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def _session(number: int) -> int:
    """How many processes there are in a session."""
    found = 0
    for process in psutil.process_iter():
        with suppress(ProcessLookupError, psutil.Error):
            found += os.getsid(process.pid) == number and process.status() != "zombie"
    return found


def main() -> None:
    """Print the table; exit status 1 where anything was not as it must be."""
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("--times", type=int, default=50, help="kills in all")
    words.add_argument("--seed", type=int, default=0)
    given = words.parse_args()
    signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))  # nothing stays behind
    chance, start = random.Random(given.seed), time.perf_counter()
    with TemporaryDirectory() as place:
        output = Path(place) / "faces.zarr"
        alone = Command(output, "none")
        if alone.end() or alone.process.returncode:
            raise SystemExit("the undisturbed command failed")
        like = contents(output)
    counts = [round(given.times * share) for share, _ in KINDS.values()]
    counts[0] += given.times - sum(counts)
    titles = ("ended it", "wordless", "twice", "half", "sets", "equal", "left")
    print(f"{'killed':<22}{'times':>6}{'units then':>12}" + _row(titles))
    whole, good = 0, True
    for (name, (_, serve)), times in zip(KINDS.items(), counts, strict=True):
        if not times:
            continue
        found = tried(serve, times, chance, like)
        moments = f"{min(found.moments)} to {max(found.moments)}"
        cells = (found.ended, len(found.wordless), found.twice, found.half)
        cells += (found.sets, found.equal, found.left)
        print(f"{name:<22}{times:>6}{moments:>12}{_row(cells)}", flush=True)
        for said in found.wordless:
            print(said)
        whole += times * found.whole
        good &= found.whole
    seconds = time.perf_counter() - start
    print(f"{whole} of {given.times} whole, {_UNITS} units a data set, {seconds:.0f} s")
    sys.exit(not good)


def _row(cells: Iterable[object]) -> str:
    return "".join(f"{cell:>9}" for cell in cells)


if __name__ == "__main__":
    main()
