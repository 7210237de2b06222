"""Executors of units: threads of this process, processes of this machine, or a Dask cluster.

A Dask worker gets the number of a unit and the place of the data set, writes the unit itself, and
returns a few numbers. It does not matter which worker makes a unit, nor how often one is asked to:
a finished unit is left alone.
"""

from __future__ import annotations

import asyncio
import signal
import socket
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import (
    FIRST_COMPLETED,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from itertools import islice
from logging import CRITICAL
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from elastomorph.blas_threads import usable_cores
from elastomorph.errors import (
    ClusterError,
    ElastomorphError,
    FormatError,
    MissingExtraError,
    ParameterError,
)
from elastomorph.farm.storage.contents import TOGETHER, Faces
from elastomorph.farm.storage.layout import REPLACED, DataSet, opened
from elastomorph.farm.storage.manifest import Shard, packing
from elastomorph.farm.storage.stores import Order, naming_store

if TYPE_CHECKING:
    from distributed import Client


# One unit of a data set: made and written whole, once, by whoever is asked to.

_BLOCK, _BLOCK_BYTES = 4 * TOGETHER, 64 * 2**20
"""Faces in memory at a time beside their codes: so many, or fewer where they are large."""


@dataclass(frozen=True)
class Made:
    """What was done: 0 seconds and bytes where the unit was finished before."""

    unit: int
    faces: int
    seconds: float
    bytes: int


def make_unit(order: Order, identity: str, unit: int) -> Made:
    """Make and write a unit, unless it is finished; the same bits wherever it is done.

    Args:
        order: Where the data set is.
        identity: Of the data set that is meant (`DataSet.identity`).
        unit: Number of the unit.

    Raises:
        FileError: The store cannot be written, or is no data set.
        FormatError: Another data set has taken the place of the one that is meant.
    """
    start = time.perf_counter()
    with naming_store(order):
        data = opened(order)
        if data.identity != identity:
            raise FormatError(order.url, REPLACED)
        rows = data.manifest.rows(unit)
        if data.manifest.finished(unit):
            return Made(unit, len(rows), 0.0, 0)
        shards = unit_shards(data, rows)
        data.require_in_place()  # Units of pictures take a minute
        data.objects.put({data.manifest.shard(n, unit): own for n, own in shards.items()})
        data.require_in_place()
        size = data.manifest.finish(unit, shards)
    return Made(unit, len(rows), time.perf_counter() - start, size)


def unit_shards(data: DataSet, rows: range) -> dict[str, bytes]:
    """The shard of every array for the faces of a unit; empty where it need not be there."""
    pack = packing(data.plan.codec, checked=data.plan.checked)
    arrays = {name: data.array(name) for name in data.plan.arrays}
    shards = {n: Shard(data.plan.unit, own.chunks[0], pack) for n, own in arrays.items()}
    for made in unit_rows(data, rows):
        for name, values in made.items():
            shards[name].add(values)
    return {name: shard.content() for name, shard in shards.items()}


def unit_rows(data: DataSet, rows: range) -> Iterator[dict[str, NDArray[Any]]]:
    """The rows of every array for some faces, a block at a time, so that little is in memory."""
    codes = data.sampler.codes(rows.start, rows.stop)
    if not data.contents:
        yield {"weights": codes}
        return
    size = sum(label.bytes for content in data.contents for label in content.labels.values())
    block = max(1, min(_BLOCK, _BLOCK_BYTES // size))
    for faces in Faces(data.poser, codes, np.arange(rows.start, rows.stop)).blocks(block):
        made: dict[str, NDArray[Any]] = {"weights": faces.codes}
        for content in data.contents:
            made |= content.made(faces)
        yield made


_ANSWER = 15.0  # Seconds in which a scheduler must answer
_PATIENCE = 60.0  # Seconds in which the first worker must come
_AHEAD = 4  # Units given to each thread of a worker, so that it never waits for the next
_RETRIES = 2  # Of a unit whose store did not answer; Dask counts workers that died by itself
_PACKAGES = ("elastomorph", "numpy", "zarr")  # Other versions may make other bits
_GOES_ON = "what is finished is kept, and the same command goes on"
_KINDS = (
    "a scheduler is none (threads of this process), local (processes of this machine), or the "
    "address of a Dask scheduler that you started, by dask-jobqueue or Kubernetes for instance, as "
    "tcp://10.0.0.1:8786"
)
# Nannies have workers give memory back at once, for which units take half as long again; and a
# worker that looks a hundred times a second what it does spends a tenth of its time on that.
_WORKERS = {
    "distributed.nanny.pre-spawn-environ.MALLOC_TRIM_THRESHOLD_": 2**28,
    "distributed.nanny.pre-spawn-environ.MALLOC_MMAP_THRESHOLD_": 2**25,
    "distributed.worker.profile.enabled": False,
}


@contextmanager
def client_of(scheduler: str | Client) -> Iterator[Client | None]:
    """Yield a client with workers of the versions of this machine; None stands for threads.

    Args:
        scheduler: ``none``, ``local``, the address of a Dask scheduler, or a client of one.

    Raises:
        ParameterError: It is none of these.
        ClusterError: The scheduler does not answer, has no workers, or they have other versions.
        MissingExtraError: Dask's scheduler is not installed.
    """
    if scheduler == "none":
        yield None
        return
    if find_spec("distributed") is None:
        raise MissingExtraError("distributed", "farm")
    from distributed import Client

    with ExitStack() as stack:
        if isinstance(scheduler, Client):
            client = scheduler
        elif scheduler == "local":
            client = stack.enter_context(_local())
        else:
            try:
                with ThreadPoolExecutor(1) as pool:  # A notebook has a loop in this thread
                    pool.submit(asyncio.run, _require_scheduler(scheduler)).result()
            except (TypeError, ValueError):  # of what is no address
                raise ParameterError(f"{_KINDS}; found {scheduler!r}") from None
            except OSError:
                raise ClusterError(
                    f"no Dask scheduler answers at {scheduler} within {_ANSWER:.0f} s: start it, "
                    "or name another"
                ) from None
            client = stack.enter_context(Client(scheduler, timeout=_ANSWER, set_as_default=False))
        _require_workers(client)
        yield client


def make_units(data: DataSet, units: Iterable[int], client: Client | None = None) -> Iterator[Made]:
    """Make units, several under way for each thread; each is yielded as it is finished.

    Raises:
        ClusterError: The scheduler is gone, workers do not reach the data set, or end again and
            again with the same unit.
        FileError: The store cannot be written.
    """
    if client is None:
        data.prepare()
        threads = usable_cores()
        task = partial(make_unit, data.order, data.identity)
        with ThreadPoolExecutor(threads) as pool:
            yield from _made(pool, lambda: threads + 1, task, units)
        return
    from distributed import KilledWorker

    # A folder must be the same one in the folder that each worker runs in.
    folder = data.order.folder
    order = data.order if folder is None else replace(data.order, url=str(folder.absolute()))
    task = partial(make_there, order, data.identity, socket.gethostname(), _versions())
    workers = client.get_executor(pure=False, retries=_RETRIES)
    try:
        yield from _made(
            workers, lambda: _AHEAD * (sum(client.nthreads().values()) or 1), task, units
        )
    except (CancelledError, OSError):  # OSError of the connection: a store's is a FileError
        raise ClusterError(f"the scheduler is gone, or was restarted: {_GOES_ON}") from None
    except KilledWorker as error:
        raise ClusterError(
            f"{error.allowed_failures + 1} workers ended one after the other with the same unit, "
            f"the last at {error.last_worker.address}: they may lack memory; {_GOES_ON}"
        ) from None


def _made(
    pool: Executor, most: Callable[[], int], task: Callable[[int], Made], units: Iterable[int]
) -> Iterator[Made]:
    left, going = iter(units), set[Future[Made]]()
    try:
        while True:
            room = max(0, most() - len(going))
            going |= {pool.submit(task, unit) for unit in islice(left, room)}
            if not going:
                return
            done, going = wait(going, return_when=FIRST_COMPLETED)
            for future in done:
                yield future.result()
    finally:
        for future in going:
            future.cancel()


def make_there(
    order: Order, identity: str, host: str, versions: Mapping[str, str | None], unit: int
) -> Made:
    """Make a unit in a worker, which may have come later than the others.

    Raises:
        ElastomorphError: As `make_unit`, naming the machine where it is another than `host`.
    """
    here = socket.gethostname()
    _require_same(versions, _versions(), here)
    try:
        return make_unit(order, identity, unit)
    except FormatError as error:
        problem = str(error).removeprefix(f"{order.url}: ")
        raise ClusterError(
            f"a worker on {here} does not find the data set {order.url} ({problem}): name a place "
            "that all machines share"
        ) from None
    except ElastomorphError as error:
        if here != host:
            raise ClusterError(f"on the machine {here}: {error}") from None
        raise


@contextmanager
def _local() -> Iterator[Client]:
    """Start a worker for each core; a nanny replaces one that dies."""
    import dask.config
    from distributed import LocalCluster

    with dask.config.set(_WORKERS), _interrupts_blocked():
        cluster = LocalCluster(
            n_workers=usable_cores(),
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            silence_logs=CRITICAL,
        )
    with cluster, cluster.get_client() as client:
        yield client


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Have threads and processes that start here never hear Ctrl-C: this process ends them."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    resource_tracker.ensure_running()  # A process of its own, which would hear again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


async def _require_scheduler(address: str) -> None:
    """Ask in a loop of its own: a `Client` that cannot connect closes slowly and loudly."""
    from distributed import Security
    from distributed.core import rpc

    arguments = Security().get_connection_args("client")
    async with rpc(address, timeout=_ANSWER, connection_args=arguments) as scheduler:
        if (await asyncio.wait_for(scheduler.identity(), _ANSWER))["type"] != "Scheduler":
            raise OSError


def _require_workers(client: Client) -> None:
    try:
        client.wait_for_workers(1, timeout=_PATIENCE)
    except TimeoutError:
        raise ClusterError(
            f"the scheduler has no workers, and none came in {_PATIENCE:.0f} s: start some with  "
            f"dask worker {client.scheduler.address}"
        ) from None
    workers = client.get_versions(packages=list(_PACKAGES))["workers"]
    for address, found in workers.items():
        _require_same(_versions(), found["packages"], address)


def _require_same(
    expected: Mapping[str, str | None], found: Mapping[str, str | None], worker: str
) -> None:
    for name, own in expected.items():
        if found.get(name) != own:
            raise ClusterError(
                f"the worker {worker} has {name} {found.get(name) or 'not installed'}, this "
                f"machine has {own}: install the same versions everywhere"
            )


def _versions() -> dict[str, str]:
    return {name: version(name) for name in _PACKAGES}


# How far a run is, and sizes and times for people.


@dataclass
class Progress:
    """How far a run is. Its text is for people."""

    faces: int  # To be made in all
    done: int  # Finished, before this run and in it
    bytes: int = 0  # Written in this run
    before: int = field(default=0)  # Finished before this run
    start: float = field(default_factory=time.monotonic)

    def __post_init__(self) -> None:
        self.before = self.done

    def add(self, made: Made) -> None:
        """Count a unit."""
        self.done += made.faces
        self.bytes += made.bytes

    @property
    def rate(self) -> float:
        """Faces a second in this run."""
        return (self.done - self.before) / max(time.monotonic() - self.start, 1e-9)

    def __str__(self) -> str:
        left = (self.faces - self.done) / self.rate if self.rate else float("inf")
        per_face = self.bytes / max(self.done - self.before, 1)
        return (
            f"{self.done:,} of {self.faces:,} faces, {rate_text(self.rate)} a second, "
            f"{size_text(self.bytes)} written, {time_text(left)} and "
            f"{size_text((self.faces - self.done) * per_face)} to go"
        )


def size_text(size: float) -> str:
    """Bytes."""
    units = ("bytes", "kB", "MB", "GB", "TB", "PB")
    power = next((p for p in range(len(units) - 1) if size < 1000 ** (p + 1)), len(units) - 1)
    return f"{size / 1000**power:,.{min(power, 1)}f} {units[power]}"


def rate_text(rate: float) -> str:
    """So many a second."""
    return f"{rate:,.0f}" if rate >= 10 else f"{rate:.2g}"


def time_text(seconds: float) -> str:
    """A time."""
    if seconds == float("inf"):
        return "unknown time"
    if seconds < 120:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:,.1f} h"
