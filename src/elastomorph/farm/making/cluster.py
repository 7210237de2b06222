"""Units made by the workers of a Dask cluster.

A worker is given the number of a unit and where the data set is, and writes the unit itself; a few
numbers come back. So it does not matter which worker makes a unit, nor how often one is asked to: a
unit that is finished is left alone.
"""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from itertools import islice
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING

from elastomorph.errors import ClusterError, ElastomorphError
from elastomorph.farm.making.unit import Made, make_unit
from elastomorph.farm.storage.layout import DataSet
from elastomorph.farm.storage.stores import Order, naming_store

if TYPE_CHECKING:
    from distributed import Client, Future

_LOOK = 1.0  # Seconds between two looks whether the cluster is still there
_AHEAD = 4  # Units given to each thread at a time: it never waits for the next
_RETRIES = 2  # Of a unit whose store did not answer; Dask counts workers that died by itself
_GOES_ON = "what is finished is kept, and the same command goes on"


@dataclass(frozen=True)
class Home:
    """The machine that asks, with which workers are compared."""

    host: str = field(default_factory=socket.gethostname)
    versions: Mapping[str, str | None] = field(
        default_factory=lambda: {name: _version(name) for name in ("elastomorph", "numpy", "zarr")}
    )

    def require_same(self, found: Mapping[str, str | None], worker: str) -> None:
        """Refuse versions that may make other bits.

        Raises:
            ClusterError: One is another than here.
        """
        for name, own in self.versions.items():
            if found.get(name) != own:
                raise ClusterError(
                    f"the worker {worker} has {name} {found.get(name) or 'not installed'}, this "
                    f"machine has {own}: install the same versions everywhere"
                )


@dataclass(frozen=True)
class Crew:
    """Workers that make units.

    Attributes:
        client: Connected to their scheduler.
        patience: Seconds without any worker after which they are given up.
        hint: What to do then.
    """

    client: Client
    patience: float
    hint: str
    home: Home = field(default_factory=Home)

    def require_fit(self) -> None:
        """Wait for the first worker, and compare the versions of those that are there.

        Raises:
            ClusterError: None comes, or one has other versions.
        """
        try:
            self.client.wait_for_workers(1, timeout=self.patience)
        except TimeoutError:
            raise ClusterError(
                f"the scheduler has no workers, and none came in {self.patience:.0f} s: {self.hint}"
            ) from None
        found = self.client.get_versions(packages=list(self.home.versions))
        for address, own in found["workers"].items():
            self.home.require_same(own["packages"], address)

    def made(self, data: DataSet, units: list[int]) -> Iterator[Made]:
        """Make units, several under way for each worker; handed on as they are finished.

        Raises:
            ClusterError: The scheduler or all workers are gone, do not reach the data set, or end
                again and again with the same unit.
            FileError: The store cannot be written.
        """
        try:
            yield from self._handed_out(_anywhere(data.order), data.identity, units)
        except OSError:  # of a connection: the store's have been made sentences by workers
            raise self._gone() from None
        if data.manifest.pending():
            raise ClusterError(
                f"{data.order.url}: workers wrote units that are not seen from here: name a place "
                "that all machines share"
            )

    def _handed_out(self, order: Order, identity: str, units: list[int]) -> Iterator[Made]:
        self._require_reach(order, identity)
        left = iter(units)
        going: set[Future] = set()
        finished: SimpleQueue[Future] = SimpleQueue()
        while True:
            for unit in islice(left, self._room(len(going))):
                future = self.client.submit(
                    make_here, order, unit, identity, self.home, pure=False, retries=_RETRIES
                )
                future.add_done_callback(finished.put)
                going.add(future)
            if not going:
                return
            future = self._next(finished)
            going.remove(future)
            yield self._result(future)

    @property
    def page(self) -> str:
        """The address of Dask's dashboard; empty where what draws it is not installed."""
        return str(self.client.dashboard_link or "") if find_spec("bokeh") else ""

    def _room(self, going: int) -> int:
        """How many units to give out, once half of those given out are finished."""
        threads = sum(self.client.nthreads().values())
        most = _AHEAD * max(threads, 1)
        return most - going if going <= most // 2 else 0

    def _require_reach(self, order: Order, identity: str) -> None:
        """Refuse workers that do not find the data set just begun."""
        answers = self.client.run(reaches, order, identity, on_error="return")
        for address, answer in answers.items():
            if isinstance(answer, OSError):
                continue  # of the connection: it has died meanwhile
            if answer is not True:
                said = f" ({answer})" if isinstance(answer, Exception) else ""
                raise ClusterError(
                    f"the worker {address} does not find the data set {order.url}{said}: name a "
                    "place that all machines share"
                )

    def _next(self, finished: SimpleQueue[Future]) -> Future:
        """The next unit that is finished."""
        alone: float | None = None
        while True:
            try:
                return finished.get(timeout=_LOOK)
            except Empty:
                if self.client.status != "running":
                    raise self._gone() from None
            now = time.monotonic()
            alone = (alone or now) if not self.client.nthreads() else None
            if alone is not None and now > alone + self.patience:
                raise ClusterError(
                    f"all workers are gone, and none came in {self.patience:.0f} s: {_GOES_ON}"
                )

    def _result(self, future: Future) -> Made:
        from distributed import KilledWorker

        if future.status in ("cancelled", "lost"):
            raise self._gone()
        try:
            made: Made = future.result()
        except KilledWorker as error:
            raise ClusterError(
                f"{error.allowed_failures + 1} workers ended one after the other with the same "
                f"unit, the last at {error.last_worker.address}: they may lack memory; {_GOES_ON}"
            ) from None
        return made

    def _gone(self) -> ClusterError:
        return ClusterError(f"the scheduler is gone, or was restarted: {_GOES_ON}")


def make_here(order: Order, unit: int, identity: str, home: Home) -> Made:
    """Make a unit where this is called, a worker; it may have come later than the others.

    Raises:
        ElastomorphError: As `make_unit`, and says which machine has a problem.
    """
    here = Home()
    home.require_same(here.versions, here.host)
    try:
        return make_unit(order, unit, identity)
    except ElastomorphError as error:
        if here.host != home.host:
            raise ClusterError(f"on the machine {here.host}: {error}") from None
        raise


def reaches(order: Order, identity: str) -> bool:
    """Whether the data set that is seen from here is the one that is meant."""
    with naming_store(order):
        return DataSet(order, read_only=True).identity == identity


def _anywhere(order: Order) -> Order:
    """The order with a folder that means the same in every folder."""
    return order if order.folder is None else replace(order, url=str(order.folder.absolute()))


def _version(name: str) -> str | None:
    try:
        return version(name)
    except PackageNotFoundError:
        return None
