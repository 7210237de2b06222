"""Runs a reader in a process of its own: a crash, a hang or a flood of memory is one error here.

Some libraries end the whole program on damaged files. A *worker* is a module that takes arrays out
of a file with such a library and ends with `serve`; `extracted` starts it and gives its arrays.

The process may use memory in proportion to the size of the file beyond what its libraries take,
and six times the processor time it took to load them (more for files beyond a megabyte), so that
slow machines get longer. Both are enforced by the operating system, where it can: on Linux, and
the time on macOS. A process that waits instead of working is stopped by the clock everywhere.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from numpy.typing import NDArray

from elastomorph.errors import FileError, FormatError
from elastomorph.io.atomic import opened
from elastomorph.io.npz.members import NpzMembers, open_npz, pack_arrays
from elastomorph.io.untrusted import MemoryBudget, allowed_memory

_REFUSED = 3
_ARRAYS, _PROBLEM, _NOISE = "arrays.npz", "problem.txt", "noise.txt"

_ROOM = 32 << 20
_SMALL = 1_000_000
_TIMES_THE_START = 6.0
_LEAST_START = 0.15
_SECONDS_A_BYTE = 2e-6
_WAIT, _WAIT_A_BYTE = 60.0, 2e-5

# Threads reserve memory that the limit counts, and one is enough for a file.
_ONE_THREAD = {"PXR_WORK_THREAD_LIMIT": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}

Content = Callable[..., Mapping[str, NDArray[Any]]]


class RefusedError(Exception):
    """A worker refuses a file; the sentence says why."""


@dataclass(frozen=True)
class IsolatedReader:
    """A worker and how to speak of it."""

    worker: str  # The module; it must end with `serve`
    library: str  # What reads the file, for messages
    advice: str  # What to do with a file that it cannot read


@contextmanager
def extracted(reader: IsolatedReader, path: str | Path, *arguments: str) -> Iterator[NpzMembers]:
    """The arrays that a worker takes out of a file; a FormatError if it refuses or breaks."""
    with opened(path) as file:
        size = file.seek(0, os.SEEK_END)
    with tempfile.TemporaryDirectory(prefix="elastomorph-") as folder:
        arrays = Path(folder) / _ARRAYS
        _run(reader, path, size, Path(folder), arguments)
        try:
            with open_npz(arrays, MemoryBudget(path, size)) as members:
                yield members
        except FileError as error:
            if error.path != arrays:
                raise
            problem = str(error).removeprefix(f"{arrays}: ")
            raise FormatError(
                path, f"its content makes no sense: {problem}; {reader.advice}"
            ) from error


def serve(prepare: Callable[[], None], content: Content) -> NoReturn:
    """Do the work of a worker and end the process; for the last line of its module.

    ``prepare`` imports what the worker needs: what it takes of memory and time is no file's fault.
    ``content`` makes arrays of the file and further arguments, or raises a `RefusedError`.
    """
    status = 1
    try:
        folder, source, size, *arguments = sys.argv[1:]
        prepare()
        _limit(int(size))
        status = _serve(content, Path(folder), source, arguments)
    except BaseException as error:  # only its last words are shown
        sys.stderr.write(f"{type(error).__name__}: {error}"[:500])
        sys.stderr.flush()
    finally:
        os._exit(status)  # the end of Python may fail in libraries after all is written


def allow_for(size: int) -> None:
    """Raise the limits of this process for another file of ``size`` bytes that it must read too.

    Does nothing in a process without them.
    """
    with suppress(AttributeError):
        left = signal.getitimer(signal.ITIMER_PROF)[0]
        if left > 0:
            signal.setitimer(signal.ITIMER_PROF, left + _SECONDS_A_BYTE * size)
    with suppress(ImportError, OSError, ValueError):
        import resource

        more = allowed_memory(size) - allowed_memory(0)
        for kind in (resource.RLIMIT_DATA, resource.RLIMIT_FSIZE):
            soft, hard = resource.getrlimit(kind)
            if soft != resource.RLIM_INFINITY:
                raised = soft + more if hard == resource.RLIM_INFINITY else min(soft + more, hard)
                resource.setrlimit(kind, (raised, hard))


def _serve(content: Content, folder: Path, source: str, arguments: list[str]) -> int:
    try:
        arrays = content(source, *arguments)
        with (folder / _ARRAYS).open("wb") as file:
            pack_arrays(file, arrays)
    except RefusedError as error:
        sentence = str(error)
    except MemoryError:
        sentence = "it needs more memory than a file of its size should"
    else:
        return 0
    (folder / _PROBLEM).write_text(sentence[:2000], encoding="utf-8", errors="backslashreplace")
    return _REFUSED


def _limit(size: int) -> None:
    """Have the system end this process where it uses too much from here on."""
    used = time.process_time()
    seconds = _TIMES_THE_START * max(used, _LEAST_START)
    seconds += _SECONDS_A_BYTE * max(0, size - _SMALL)
    with suppress(AttributeError):  # Windows has neither
        signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        import resource
    except ImportError:
        return
    memory = _ROOM + allowed_memory(size)
    kinds = {
        resource.RLIMIT_DATA: _private_memory() + memory,
        resource.RLIMIT_FSIZE: memory,
        resource.RLIMIT_CORE: 0,
    }
    for kind, wanted in kinds.items():
        with suppress(OSError, ValueError):  # macOS refuses some of them
            hard = resource.getrlimit(kind)[1]
            allowed = wanted if hard == resource.RLIM_INFINITY else min(wanted, hard)
            resource.setrlimit(kind, (allowed, hard))


def _private_memory() -> int:
    """Bytes that count against the limit already; without Linux unknown, and enough."""
    with suppress(OSError, ValueError):
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmData:"):
                return int(line.split()[1]) << 10
    return 1 << 30


def own_process(module: str) -> tuple[list[str], dict[str, str]]:
    """The command that runs a module of ours, and an environment in which it finds what we do."""
    found = [str(Path(place).absolute()) for place in sys.path if place]
    # -P: a module of that name in the current folder is not ours.
    command = [sys.executable, "-P", "-m", module]
    return command, os.environ | {"PYTHONPATH": os.pathsep.join(found)}


def _run(
    reader: IsolatedReader, path: str | Path, size: int, folder: Path, arguments: tuple[str, ...]
) -> None:
    if not sys.executable:
        raise FileError(
            path,
            f"{reader.library} reads it in a process of its own, but this Python does not know its "
            "interpreter; convert the file with the command 'elastomorph' first",
        )
    command, environment = own_process(reader.worker)
    wait = _WAIT + _WAIT_A_BYTE * size
    try:
        with (folder / _NOISE).open("wb") as noise:
            done = subprocess.run(
                [*command, str(folder), str(Path(path).absolute()), str(size), *arguments],
                env=environment | _ONE_THREAD,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=noise,
                timeout=wait,
                check=False,
            )
    except subprocess.TimeoutExpired:
        raise FormatError(
            path, f"{reader.library} did not finish reading it within {wait:.0f} s; {reader.advice}"
        ) from None
    except (OSError, ValueError) as error:
        raise FileError(path, f"no process could be started to read it: {error}") from error
    problem = folder / _PROBLEM
    if done.returncode == _REFUSED and problem.is_file():
        raise FormatError(path, problem.read_text(encoding="utf-8"))
    if done.returncode != 0 or not (folder / _ARRAYS).is_file():
        death = _death(done.returncode, folder / _NOISE)
        raise FormatError(
            path,
            f"{reader.library} broke while reading it ({death}): it is damaged, or takes far more "
            f"than a file of its size should; {reader.advice}",
        )


def _death(status: int, noise: Path) -> str:
    if status < 0:
        names = {-sign: sign.name for sign in signal.Signals}
        name = names.get(status, f"signal {-status}")
        return f"{name}, too much time" if name == "SIGPROF" else name
    said = noise.read_bytes()[-2000:].decode("utf-8", "backslashreplace").strip()
    return said.splitlines()[-1][:200] if said else f"exit status {status}"
