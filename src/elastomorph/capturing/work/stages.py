"""A working folder: the result of each stage of a long work, with what it depended on.

A stage is made when its file is missing, damaged, or was made from something else: other contents
of files, other options, other results of earlier stages, another version of its code. What a stage
depends on is told by digests, and of an earlier stage it is that of its result, so that where an
earlier one is made again with the same result, nothing after it is.

A result is written under another name and renamed when all of it is on the disk. Whenever a work
ends, however it ends, each file of the folder is a whole result, and the same work goes on behind
the last one.
"""

from __future__ import annotations

import errno
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, Generic, TypeVar

import numpy as np

from elastomorph.capturing.work.packing import content_digest, packed, unpacked
from elastomorph.errors import ElastomorphError, FileError
from elastomorph.io.atomic import made_folder, unnoted
from elastomorph.io.npz.members import open_npz, write_arrays
from elastomorph.io.rig_cache import settings_digest

T = TypeVar("T")

_LOCK = ".lock"
_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_BUSY = (
    "another process is working in this folder; wait for its end, or name another with --working"
)


@dataclass(frozen=True)
class Made(Generic[T]):
    """A result that is in the working folder.

    Attributes:
        file: It, an archive of arrays.
        digest: Of its content.
        seconds: That it took to make.
        anew: Whether it was made in this run.
    """

    file: Path
    digest: str
    seconds: float
    anew: bool

    def read(self) -> T:
        """The result, read from its file each time, so that results need not stay in memory."""
        with unnoted(), open_npz(self.file) as members:
            return unpacked(members)  # type: ignore[no-any-return]


class WorkingFolder:
    """The working folder of one process at a time; used with ``with``.

    Args:
        folder: Made where it is missing.

    Raises:
        FileError: It cannot be written, or another process works in it; when it is entered.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._lock: IO[bytes] | None = None

    def __enter__(self) -> WorkingFolder:
        """Lock it."""
        place = made_folder(self.folder) / _LOCK
        try:
            self._lock = place.open("ab")
        except OSError as error:
            raise FileError(self.folder, f"it cannot be written in: {error.strerror}") from error
        try:
            _lock(self._lock)
        except OSError:
            self._lock.close()
            raise FileError(self.folder, _BUSY) from None
        return self

    def __exit__(self, *error: object) -> None:
        """Let others in; the system does so too where the process is killed."""
        if self._lock is not None:
            self._lock.close()

    def made(
        self, stage: str, depends: Mapping[str, object], make: Callable[[], T], version: object
    ) -> Made[T]:
        """The result of a stage, made where it is not there.

        Args:
            stage: Its name, as "cameras/smile": that of its file in the folder.
            depends: All that it depends on, by name: digests, options, arrays.
            make: Makes it.
            version: Of the code that makes it.

        Raises:
            FileError: The result cannot be written; those before it are there.
        """
        file = self.folder / f"{stage}.npz"
        key = settings_digest(stage, version, dict(depends))
        if key is None:
            raise TypeError(f"what the stage {stage} depends on has no digest")
        known = self.known(stage, key)
        if known is not None:
            return known
        start = time.monotonic()
        arrays = packed(make())
        seconds = time.monotonic() - start
        digest = content_digest(arrays)
        about = {"key": np.array(key), "digest": np.array(digest), "seconds": np.array(seconds)}
        with unnoted(), _saying_what_is_kept(self.folder):
            made_folder(file.parent)
            write_arrays(file, about | arrays)
        return Made(file, digest, seconds, anew=True)

    def known(self, stage: str, key: str | None = None) -> Made[Any] | None:
        """What is in the folder of a stage, whole and of this key; None where nothing is."""
        file = self.folder / f"{stage}.npz"
        with suppress(ElastomorphError, OSError), unnoted(), open_npz(file) as members:
            if key is not None and str(members.array("key", "U", ())) != key:
                return None
            unpacked(members)  # the checksums of an archive are only looked at where it is read
            digest = str(members.array("digest", "U", ()))
            return Made(file, digest, float(members.array("seconds", "f", ())), anew=False)
        return None


@contextmanager
def _saying_what_is_kept(folder: Path) -> Iterator[None]:
    """Where the disk is full, say so and what to do."""
    try:
        yield
    except FileError as error:
        if getattr(error.__cause__, "errno", None) not in _FULL:
            raise
        raise FileError(
            folder,
            "the disk is full; what was finished is kept: make room and run the same command again",
        ) from error


def _lock(file: IO[bytes]) -> None:
    """Lock a file for this process, or raise OSError; the end of the process unlocks it."""
    if sys.platform == "win32":
        import msvcrt

        file.seek(0)
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
