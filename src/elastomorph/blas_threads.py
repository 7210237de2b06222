"""Products on all cores: threads of our own, each with one thread of BLAS.

The threads of a BLAS library wait for each other at the end of every product. Where another process
keeps a core busy they wait for a turn of the scheduler each time, and a hundred small products take
seconds. Threads that share nothing but a list of tasks do not wait.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import lru_cache
from threading import Lock
from typing import Any, TypeVar

Task = TypeVar("Task")


def in_own_threads(work: Callable[[Task], object], tasks: Iterable[Task]) -> None:
    """Do all tasks, with one BLAS thread each: in threads of our own if there are several.

    There are as many threads as BLAS would use (``OPENBLAS_NUM_THREADS``, ``threadpool_limits``),
    at most one for each core this process may use. None outlives the call. Tasks must not share
    what they write, and be worth about a millisecond each: starting one costs a fortieth. After the
    error of a task, those not yet begun are left out.
    """
    waiting = list(tasks)
    with one_blas_thread() as allowed:
        threads = min(allowed, usable_cores(), len(waiting))
        if threads <= 1:
            for task in waiting:
                work(task)
            return
        with ThreadPoolExecutor(threads, initializer=_limit_this_thread) as pool:
            for _ in pool.map(work, waiting):
                pass


@contextmanager
def one_blas_thread() -> Iterator[int]:
    """One BLAS thread as long as any thread of this process is inside.

    Yields how many threads BLAS would use otherwise; all cores where nothing is known of it.
    """
    libraries = _libraries()
    _inside.enter(libraries)
    try:
        yield max(_inside.before, default=usable_cores())
    finally:
        _inside.leave(libraries)


def usable_cores() -> int:
    """How many cores this process may use."""
    if hasattr(os, "process_cpu_count"):
        return os.process_cpu_count() or 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0)) or 1
    return os.cpu_count() or 1


class _Inside:
    """How many calls are inside, and what the number of threads was before the first of them.

    The number belongs to the process: the call that leaves last puts it back, whichever was first.
    """

    def __init__(self) -> None:
        self.lock = Lock()
        self.calls = 0
        self.before: list[int] = []

    def enter(self, libraries: tuple[Any, ...]) -> None:
        with self.lock:
            if not self.calls:
                self.before = [library.get_num_threads() or 1 for library in libraries]
            self.calls += 1
            for library in libraries:
                _set_threads(library, 1)

    def leave(self, libraries: tuple[Any, ...]) -> None:
        with self.lock:
            self.calls -= 1
            for library, count in zip(libraries, self.before, strict=True):
                if not self.calls or _counts_by_thread(library):
                    _set_threads(library, count)


_inside = _Inside()
if hasattr(os, "register_at_fork"):
    # A child has none of the threads that were inside, nor would any of them leave.
    os.register_at_fork(after_in_child=_inside.__init__)  # type: ignore[misc]


@lru_cache(maxsize=1)
def _libraries() -> tuple[Any, ...]:
    """The BLAS libraries of NumPy and SciPy, found once, for that takes a millisecond."""
    import scipy.linalg.blas  # noqa: F401  (so that its library is loaded and found)
    from threadpoolctl import ThreadpoolController

    found = ThreadpoolController().select(user_api="blas").lib_controllers
    return tuple(found)


def _set_threads(library: Any, count: int) -> None:
    if library.get_num_threads() == count:
        return
    # Recent versions of threadpoolctl let only the thread that set a number first change it. Ours
    # take turns by a lock instead, and the last to leave may be another than the first.
    release = getattr(library, "clear_controlling_thread", None)
    if release is not None:
        release(force=True)
    library.set_num_threads(count)
    if release is not None:
        release(force=True)


def _limit_this_thread() -> None:
    for library in _libraries():
        if _counts_by_thread(library):
            _set_threads(library, 1)


def _counts_by_thread(library: Any) -> bool:
    """Whether each thread that calls the library has a number of its own."""
    return getattr(library, "threading_layer", "") == "openmp"
