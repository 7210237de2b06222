"""What ``--scheduler`` names: processes of this machine, a scheduler's address, or a queue."""

from __future__ import annotations

import asyncio
import json
import logging
import os
import signal
import warnings
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from importlib.util import find_spec
from multiprocessing import resource_tracker
from pathlib import Path
from typing import TYPE_CHECKING, Any

from elastomorph.blas_threads import usable_cores
from elastomorph.errors import ClusterError, MissingExtraError, ParameterError
from elastomorph.farm.making.cluster import Crew
from elastomorph.farm.making.main_guard import require_guarded_main
from elastomorph.farm.making.queues import MEMORY_KEPT, Queue, read_queue

if TYPE_CHECKING:
    from distributed import Client

LOOPBACK = "127.0.0.1:0"
"""Where a dashboard is: a free port of this machine, for this machine alone."""

_ANSWER = 15.0  # Seconds in which a scheduler must answer
_PATIENCE = 60.0  # Seconds without any worker: they have gone, or never came
_CLOSING = 20.0  # Seconds for workers to end; on a busy machine that takes a while
_SILENT = logging.CRITICAL + 1
_NOISY = ("asyncio", "tornado", "tornado.application", "tornado.general")


@contextmanager
def crew_of(scheduler: str, dashboard: str = LOOPBACK) -> Iterator[Crew]:
    """The workers that a user's word stands for, their versions compared; ours end with it.

    Args:
        scheduler: ``local``, the address of a scheduler (``host:port`` or ``tcp://host:port``) or
            the .json file it wrote, or a .toml file that describes jobs of a queue.
        dashboard: Address and port of the page that shows what our workers do.

    Raises:
        ParameterError: It is none of these, or a script would start itself again and again.
        ClusterError: The scheduler does not answer, has no workers, or they have other versions.
    """
    if not isinstance(scheduler, str):
        raise ParameterError(f"a scheduler is named by a text, found {scheduler!r}")
    if find_spec("distributed") is None:
        raise MissingExtraError("distributed", "farm")
    with ExitStack() as stack:
        stack.enter_context(_quiet())
        if scheduler == "local":
            crew = Crew(stack.enter_context(_local(dashboard)), _PATIENCE, "none started")
        elif scheduler.endswith(".toml"):
            queue = read_queue(scheduler)
            hint = f"no job of {queue.path} runs: look at the queue, or raise 'patience' there"
            crew = Crew(stack.enter_context(_jobs(queue, dashboard)), queue.patience, hint)
        else:
            address = _address(scheduler)
            hint = f"start some with  dask worker {address}"
            crew = Crew(stack.enter_context(_running(address)), _PATIENCE, hint)
        crew.require_fit()
        yield crew


@contextmanager
def _local(dashboard: str) -> Iterator[Client]:
    """A worker for each core, with its share of the memory; a nanny replaces one that dies."""
    require_guarded_main()
    import dask.config
    from distributed import LocalCluster

    environment = "distributed.nanny.pre-spawn-environ"
    variables = {**dask.config.get(environment), **MEMORY_KEPT}
    with _environment_kept():
        with (
            dask.config.set({environment: variables, "distributed.worker.profile.enabled": False}),
            _as_sentence("the processes of this machine did not start"),
            _interrupts_kept(),
        ):
            cluster = LocalCluster(
                n_workers=usable_cores(),
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address=dashboard,
                silence_logs=_SILENT,
            )
        with _closed(cluster), _client(cluster) as client:
            yield client


@contextmanager
def _jobs(queue: Queue, dashboard: str) -> Iterator[Client]:
    """As many jobs as a file asks for; one that ends early is followed by another."""
    with _environment_kept():
        with _as_sentence(f"{queue.path}: {queue.kind.__name__} refuses this"):
            cluster = queue.cluster(dashboard, _SILENT)
        with _closed(cluster):
            with _as_sentence(f"{queue.path}: no job could be handed in"):
                cluster.scale(jobs=queue.jobs)
                cluster.sync(_handed_in, cluster)
                cluster.adapt(minimum_jobs=queue.jobs, maximum_jobs=queue.jobs)
            with _client(cluster) as client:
                yield client


@contextmanager
def _running(address: str) -> Iterator[Client]:
    """A scheduler that somebody else has started."""
    # In a loop of its own: a client that cannot connect closes slowly and loudly.
    with _as_sentence(f"{address} is no Dask scheduler that suits"), ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, _answer(address)).result()
    with _client(address) as client:
        yield client


def _address(scheduler: str) -> str:
    if scheduler.endswith(".json"):
        try:
            return str(json.loads(Path(scheduler).read_bytes())["address"])
        except (OSError, ValueError, LookupError, TypeError):
            raise ParameterError(
                f"{scheduler} is no file of a running scheduler: start it with  "
                f"dask scheduler --scheduler-file {scheduler}"
            ) from None
    host, _, port = scheduler.rpartition(":")
    if not host or not port.isdecimal():
        raise ParameterError(
            "a scheduler is none, local, an address such as tcp://10.0.0.1:8786, the .json file of "
            f"one, or a .toml file that describes a queue; found {scheduler!r}"
        )
    return scheduler


async def _answer(address: str) -> None:
    from distributed import Security
    from distributed.core import rpc

    own = Security().get_connection_args("client")
    try:
        async with rpc(address, timeout=_ANSWER, connection_args=own) as scheduler:
            kind = (await asyncio.wait_for(scheduler.identity(), _ANSWER))["type"]
    except OSError:
        raise ClusterError(
            f"no Dask scheduler answers at {address} within {_ANSWER:.0f} s: start it, or name "
            "another"
        ) from None
    if kind != "Scheduler":
        raise ValueError(f"it is a {kind}")


async def _handed_in(cluster: Any) -> None:
    await cluster


@contextmanager
def _client(where: Any) -> Iterator[Client]:
    from distributed import Client
    from distributed.versions import VersionMismatchWarning

    with warnings.catch_warnings(), _as_sentence("the scheduler does not answer"):
        warnings.simplefilter("ignore", VersionMismatchWarning)  # we compare them ourselves
        client = Client(where, timeout=_ANSWER, set_as_default=False)
    with _closed(client):
        yield client


@contextmanager
def _closed(own: Any) -> Iterator[None]:
    try:
        yield
    finally:
        with suppress(TimeoutError, OSError):
            own.close(timeout=_CLOSING)


@contextmanager
def _as_sentence(what: str) -> Iterator[None]:
    try:
        yield
    except ClusterError:
        raise
    except Exception as error:
        cause = str(error).split("\n")[0].rstrip(".:") or type(error).__name__
        raise ClusterError(f"{what}: {cause}") from error


@contextmanager
def _interrupts_kept() -> Iterator[None]:
    """Ctrl-C waits, and is never heard by threads and processes begun here: we end them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # the first to ask for it would hear again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _environment_kept() -> Iterator[None]:
    """Nannies set variables for their processes in ours too, such as one thread for BLAS."""
    before = dict(os.environ)
    try:
        yield
    finally:
        for name in os.environ.keys() - before.keys():
            del os.environ[name]


@contextmanager
def _quiet() -> Iterator[None]:
    """What Dask logs is told by our own sentences, or of no interest to who makes faces."""
    from distributed.utils import silence_logging_cmgr

    levels = {name: logging.getLogger(name).level for name in _NOISY}
    with silence_logging_cmgr(_SILENT):
        try:
            for name in _NOISY:
                logging.getLogger(name).setLevel(_SILENT)
            yield
        finally:
            for name, level in levels.items():
                logging.getLogger(name).setLevel(level)
