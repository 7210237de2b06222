"""Who makes the units of a data set: threads of this process, or workers elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from dataclasses import dataclass

from elastomorph.blas_threads import usable_cores
from elastomorph.farm.making.unit import Made, make_unit
from elastomorph.farm.storage.layout import DataSet


@dataclass(frozen=True)
class Team:
    """Who makes units.

    Attributes:
        made: Makes units of a data set, and hands on each as it is finished.
        page: The address of a page that shows who does what; empty where there is none.
    """

    made: Callable[[DataSet, list[int]], Iterator[Made]]
    page: str = ""


@contextmanager
def team_of(scheduler: str, dashboard: str | None = None) -> Iterator[Team]:
    """Those that a user's word stands for: ``none`` for threads, or a word for `crew_of`."""
    if scheduler == "none":
        yield THREADS
        return
    from elastomorph.farm.making.schedulers import LOOPBACK, crew_of

    with crew_of(scheduler, dashboard or LOOPBACK) as crew:
        yield Team(crew.made, crew.page)


def made_units(data: DataSet, units: list[int]) -> Iterator[Made]:
    """Make units in threads, a few more under way than there are cores; as they are finished."""
    if units:
        data.prepare()
    threads = min(usable_cores(), len(units)) or 1
    pool = ThreadPoolExecutor(threads)
    try:
        left, going = iter(units), set[Future[Made]]()
        while True:
            for unit in left:
                going.add(pool.submit(make_unit, data.order, unit, data.identity))
                if len(going) > threads:
                    break
            if not going:
                return
            done, going = wait(going, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
    finally:
        pool.shutdown(cancel_futures=True)


THREADS = Team(made_units)
