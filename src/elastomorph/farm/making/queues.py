"""Jobs of a queue (SLURM and others) as a file describes them."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from elastomorph.character.document import nearest, open_document
from elastomorph.errors import MissingExtraError
from elastomorph.farm.sampling.keys import RecipeKey, read_value

_KEYS = {
    "jobs": RecipeKey("whole", "how many jobs are asked for", "20", least=1),
    "patience": RecipeKey("number", "seconds that all jobs may be waiting", "7200", above=0),
}
_HOUR = 3600.0

MEMORY_KEPT = {"MALLOC_TRIM_THRESHOLD_": 2**28, "MALLOC_MMAP_THRESHOLD_": 2**25}
"""For workers: Dask has them give memory back at once, and units took half as long again."""
_UNWATCHED = {"DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": False}  # a tenth of a worker's time


@dataclass(frozen=True)
class Queue:
    """A queue of jobs, each of which is one or more workers.

    Attributes:
        path: The file.
        kind: The class of dask-jobqueue.
        arguments: Its arguments.
        jobs: How many are asked for.
        patience: Seconds that all of them may be waiting in the queue.
    """

    path: Path
    kind: Any
    arguments: Mapping[str, Any]
    jobs: int = 1
    patience: float = _HOUR

    def cluster(self, dashboard: str, level: int) -> Any:
        """A cluster without jobs; its scheduler is in this process.

        Args:
            dashboard: Where its page is, unless the file says it.
            level: Of what is logged.
        """
        options = {"dashboard_address": dashboard, **self.arguments.get("scheduler_options", {})}
        variables = MEMORY_KEPT | _UNWATCHED
        exports = [f"export {name}={value}" for name, value in variables.items()]
        own = {
            **self.arguments,
            "scheduler_options": options,
            "job_script_prologue": [*exports, *self.arguments.get("job_script_prologue", [])],
            "silence_logs": level,
        }
        cluster = self.kind(**own)
        command = str(self.kind.job_cls.submit_command or "").split()
        if command and shutil.which(command[0]) is None:
            cluster.close()
            raise FileNotFoundError(f"there is no command '{command[0]}' on this machine")
        return cluster


def read_queue(path: str | Path) -> Queue:
    """The queue that a .toml file describes.

    Raises:
        FileError: It is missing or cannot be read.
        FormatError: It is no TOML, or has a key, class or value that there is not.
        MissingExtraError: dask-jobqueue is not installed.
    """
    document = open_document(path)
    document.require_known((), ["class", *_KEYS, "arguments"])
    kinds = _kinds()
    name = document.content.get("class")
    if not isinstance(name, str) or name not in kinds:
        hint = nearest(str(name or ""), kinds)
        document.refuse(
            ("class",), f"'class' is a cluster of dask-jobqueue, found {name!r}: {hint}"
        )
    values = {
        key: read_value(document, (key,), own, document.content[key])
        for key, own in _KEYS.items()
        if key in document.content
    }
    return Queue(Path(path), kinds[name], document.table(("arguments",)), **values)


def _kinds() -> dict[str, Any]:
    """The clusters of dask-jobqueue by their names."""
    try:
        import dask_jobqueue
        from dask_jobqueue.local import LocalCluster
    except ImportError:
        raise MissingExtraError("dask-jobqueue") from None
    named = {name: kind for name, kind in vars(dask_jobqueue).items() if isinstance(kind, type)}
    del named["JobQueueCluster"]
    return named | {"LocalCluster": LocalCluster}
