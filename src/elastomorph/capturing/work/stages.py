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
import json
import math
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, fields, is_dataclass
from hashlib import blake2b
from importlib import import_module
from pathlib import Path
from typing import IO, Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from elastomorph.errors import ElastomorphError, FileError, FormatError
from elastomorph.io.atomic import made_folder, unnoted
from elastomorph.io.npz.members import NpzMembers, open_npz, write_arrays
from elastomorph.io.rig_cache import settings_digest

# Results of stages as arrays of an archive, and back.
#
# A result is made of frozen dataclasses of this room, mappings, tuples, lists, arrays, numbers
# and texts. Arrays become members of the archive; all else is one text of JSON that says where
# each of them belongs. Nothing is ever unpickled: of classes, only dataclasses of this room are
# made.

_LAYOUT = "layout"
_ROOM = "elastomorph.capturing"
_SCALARS = (bool, int, str, type(None))


def packed(value: object) -> dict[str, NDArray[Any]]:
    """A result as arrays."""
    arrays: dict[str, NDArray[Any]] = {}
    layout = _described(value, arrays)
    arrays[_LAYOUT] = np.array(json.dumps(layout, ensure_ascii=True))
    return arrays


def unpacked(members: NpzMembers) -> Any:
    """The result that arrays of an archive were packed from.

    Raises:
        FormatError: The archive holds something else.
    """
    try:
        return _restored(json.loads(str(members.array(_LAYOUT, "U", ()))), members)
    except (ValueError, KeyError, TypeError, AttributeError, ImportError, RecursionError) as error:
        raise FormatError(members.path, f"it holds no result of a stage: {error}") from error


def content_digest(arrays: Mapping[str, NDArray[Any]]) -> str:
    """A digest that differs wherever packed results do."""
    digest = blake2b(digest_size=16)
    for name, array in arrays.items():
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def _described(value: Any, arrays: dict[str, NDArray[Any]]) -> Any:
    """What stands for a value in JSON: a scalar itself, anything else as [kind, content]."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, _SCALARS):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else ["float", repr(value)]
    if isinstance(value, Path):
        return ["path", str(value)]
    if isinstance(value, np.ndarray):
        name = f"array{len(arrays)}"
        arrays[name] = value
        return ["array", name, value.dtype.kind, value.ndim]
    if isinstance(value, Mapping):
        pairs = [[_described(part, arrays) for part in pair] for pair in value.items()]
        return ["mapping", pairs]
    if isinstance(value, tuple | list):
        kind = "tuple" if isinstance(value, tuple) else "list"
        return [kind, [_described(part, arrays) for part in value]]
    if is_dataclass(value) and not isinstance(value, type):
        own = type(value)
        content = {
            each.name: _described(getattr(value, each.name), arrays)
            for each in fields(value)
            if each.init
        }
        return ["object", own.__module__, own.__qualname__, content]
    raise TypeError(f"a result of a stage cannot hold {type(value).__name__}")


def _restored(described: Any, members: NpzMembers) -> Any:
    if not isinstance(described, list):
        return described
    kind, *content = described
    if kind == "array":
        name, type_of, size = content
        return members.array(name, type_of, (None,) * size)
    if kind == "object":
        module, name, values = content
        made = _class_of(module, name)
        return made(**{key: _restored(value, members) for key, value in values.items()})
    if kind == "mapping":
        return {_restored(key, members): _restored(value, members) for key, value in content[0]}
    if kind in ("tuple", "list"):
        parts = [_restored(part, members) for part in content[0]]
        return tuple(parts) if kind == "tuple" else parts
    return {"float": float, "path": Path}[kind](content[0])


def _class_of(module: str, name: str) -> Any:
    """A dataclass of this room by its name."""
    found = getattr(import_module(module), name) if f"{module}.".startswith(f"{_ROOM}.") else None
    if not (isinstance(found, type) and is_dataclass(found)):
        raise ValueError(f"{module}.{name} is no result")
    return found


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
