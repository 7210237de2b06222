"""Executors of units: threads of this process, processes of this machine, or a Dask cluster.

A Dask worker gets the number of a unit and the place of the data set, writes the unit itself, and
returns a few numbers. It does not matter which worker makes a unit, nor how often one is asked to:
a finished unit is left alone.
"""

from __future__ import annotations

import asyncio
import signal
import socket
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
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from itertools import islice
from logging import CRITICAL
from multiprocessing import resource_tracker
from typing import TYPE_CHECKING

from elastomorph.blas_threads import usable_cores
from elastomorph.errors import (
    ClusterError,
    ElastomorphError,
    FormatError,
    MissingExtraError,
    ParameterError,
)
from elastomorph.farm.making.unit import Made, make_unit
from elastomorph.farm.storage.layout import DataSet
from elastomorph.farm.storage.stores import Order

if TYPE_CHECKING:
    from distributed import Client

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
