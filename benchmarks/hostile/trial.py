"""Reads hostile inputs one after another in this process and reports on each.

Started by `hostile.table` as ``python -m hostile.trial FORMAT SEED FIRST FOLDER``; it writes a line
of JSON before each input and one after it, so that the input that ended the process is known. The
lines that are read on its standard input say how far it may go on.
"""

from __future__ import annotations

import ctypes
import gc
import itertools
import json
import os
import resource
import sys
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from random import Random
from typing import Any

from elastomorph.errors import ElastomorphError
from hostile.byte_changes import MOST_BYTES
from hostile.case import Case
from hostile.formats import FORMATS, Format
from hostile.judge import WrongError, is_small, judged

__all__ = ["cases", "find_format", "tried"]

MOST_SECONDS = 2.0
MOST_MEMORY = 256 << 20
_LARGEST_PROCESS = 4 << 30
_AGAIN_EVERY = 5
_TRIES, _HOPELESS = 3, 8.0
_WAITING = 15.0
_FREE = ctypes.CDLL(None) if sys.platform == "linux" else None


def find_format(name: str) -> Format:
    """The format of a name."""
    return next(known for known in FORMATS if known.name == name)


def cases(known: Format, seed: int, first: int = 0) -> Iterator[tuple[Case, bool]]:
    """All inputs of a format from a number on; endless, and the same for the same seed.

    Yields:
        An input, and whether it is one that chance has no part in.
    """
    fixed = 0
    for fixed, case in enumerate(known.fixed(), start=1):
        if fixed > first:
            yield case, True
    cuts = known.cuts()
    Random(f"{seed}/{known.name}").shuffle(cuts)
    for number in itertools.count(max(first, fixed)):
        turn, by_chance = divmod(number - fixed, 2)
        if not by_chance and turn < len(cuts):
            yield known.cut(*cuts[turn]), False
        else:
            yield known.random(Random(f"{seed}/{known.name}/{number}")), False


def tried(known: Format, case: Case, number: int, folder: Path) -> dict[str, Any]:
    """Read an input and say what came of it.

    Returns:
        ``outcome`` is "loaded", "refused" or "failed", ``problem`` says how it failed; ``seconds``
        of processor time, and ``memory``, bytes above the start at the peak, in this process or
        one it started.
    """
    try:
        path = case.write(folder)
    except (OSError, ValueError) as error:  # a name that this file system cannot have
        path = folder / "inside" / case.name
        if case.wanted == "loaded":
            raise error
    gc.collect()
    if _FREE is not None:
        _FREE.malloc_trim(0)
    small = case.size <= MOST_BYTES
    seconds, memory = float("inf"), 0
    for _ in range(_TRIES):
        watch = _Watch(known.isolated)
        start, begin = _processor_time(), time.perf_counter()
        thing, message, problem = None, "", ""
        try:
            thing, message = judged(known.read, path, folder)
        except WrongError as error:
            problem = str(error)
        except BaseException:
            problem = traceback.format_exc(limit=-6)
        used, waited = _processor_time() - start, time.perf_counter() - begin
        # On a machine with other work the clock says little, unless the reader does not work.
        seconds = min(seconds, waited if waited > _WAITING else used)
        memory = max(memory, watch.stop())
        # Whether the reader was slow or the machine busy, another try shows.
        if problem or seconds < MOST_SECONDS or seconds > _HOPELESS:
            break
    if not problem and thing is not None:
        problem = _problem_of(known, case, thing, number, folder)
    if not problem and case.wanted == "loaded" and message:
        problem = f"refused, though it must load: {message}"
    if not problem and case.wanted == "refused" and not message:
        problem = "loaded, though it must be refused"
    if not problem and small and seconds > MOST_SECONDS:
        problem = f"took {seconds:.1f} s"
    if not problem and small and memory > MOST_MEMORY:
        problem = f"took {memory >> 20} MB of memory"
    outcome = "failed" if problem else "refused" if message else "loaded"
    return {
        "outcome": outcome,
        "problem": problem,
        "label": case.label,
        "message": message,
        "seconds": seconds,
        "memory": memory,
        "small": small,
    }


def _problem_of(known: Format, case: Case, thing: Any, number: int, folder: Path) -> str:
    try:
        known.judge(thing)
        chosen = number % _AGAIN_EVERY == 0 or case.wanted == "loaded"
        if known.again is not None and chosen and is_small(thing):
            with suppress(ElastomorphError):  # not all that can be read can be written
                known.again(thing, folder)
    except WrongError as error:
        return str(error)
    except BaseException:
        return "after reading: " + traceback.format_exc(limit=-6)
    return ""


def _processor_time() -> float:
    """Seconds of this process and those it started and waited for."""
    both = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(used.ru_utime + used.ru_stime for used in both)


class _Watch:
    """The most memory above the start, of this process and of processes it starts."""

    def __init__(self, children: bool) -> None:
        with suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5")  # the peak from here on
        self._start = _status("self", "VmRSS")
        self.children = 0
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._look) if children else None
        if self._thread:
            self._thread.start()

    def stop(self) -> int:
        """The peak so far, in bytes."""
        own = _status("self", "VmHWM") - self._start
        if self._thread:
            self._done.set()
            self._thread.join()
        return max(own, self.children)

    def _look(self) -> None:
        started: dict[str, int] = {}
        list_file = Path(f"/proc/self/task/{os.getpid()}/children")
        while not self._done.wait(0.002):
            with suppress(OSError):
                for child in list_file.read_text().split():
                    with suppress(OSError, ValueError):
                        peak = _status(child, "VmHWM")
                        started[child] = max(started.get(child, 0), peak)
        # What Python and the libraries take is where such a process starts.
        self.children = max([0, *(peak - _bare["child"] for peak in started.values())])


def _measure_bare(known: Format, folder: Path) -> None:
    """Take a process that reads a tiny file as what any such process takes."""
    _bare["child"] = 0
    whole = Case("whole", known.file, {known.file: known.whole()[0]})
    path = whole.write(folder)
    peaks = []
    for _ in range(3):
        watch = _Watch(True)
        known.read(path)
        watch.stop()
        peaks.append(watch.children)
    _bare["child"] = min(peaks)


_bare = {"child": 0}


def _status(process: str, key: str) -> int:
    for line in Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith(f"{key}:"):
            return int(line.split()[1]) << 10
    return 0


def main(name: str, seed: str, first: str, folder: str) -> None:
    """Try inputs until told to stop."""
    resource.setrlimit(resource.RLIMIT_DATA, (_LARGEST_PROCESS, resource.RLIM_INFINITY))
    known = find_format(name)
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    if known.isolated:
        _measure_bare(known, place)
    number = int(first)
    made = cases(known, int(seed), number)
    by_hand = True
    for line in sys.stdin:
        stop = time.monotonic() + float(line)
        while time.monotonic() < stop:
            case, by_hand = next(made)
            print(json.dumps({"number": number, "label": case.label}), flush=True)
            print(json.dumps(tried(known, case, number, place)), flush=True)
            number += 1
        print(json.dumps({"paused": number, "by_hand": by_hand}), flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
