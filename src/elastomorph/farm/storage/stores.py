"""Where a data set lies: a local folder, or any address that fsspec knows, as a Zarr store."""

from __future__ import annotations

import asyncio
import json
import os
import time
from collections.abc import Callable, Coroutine, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar
from uuid import uuid4

from elastomorph.errors import (
    ElastomorphError,
    FileError,
    FormatError,
    MissingExtraError,
    ParameterError,
)

try:
    from fcntl import LOCK_EX, flock
except ImportError:  # Windows
    flock = None  # type: ignore[assignment]

if TYPE_CHECKING:
    from zarr.abc.store import Store

Result = TypeVar("Result")

_AT_ONCE = 32  # Requests under way together: stores far away answer slowly
_MINUTE = 60.0
_MAKE_AGAIN = "--verify names the file: remove it, and give the command that made it again"


@dataclass(frozen=True)
class Order:
    """All that a worker needs to know of a data set: where it is. Small, and can be pickled.

    Attributes:
        url: A folder, or an address as fsspec takes it.
        storage_options: What fsspec needs to reach it.
    """

    url: str
    storage_options: Mapping[str, Any] = field(default_factory=dict)

    @cached_property
    def key(self) -> tuple[str, str]:
        """What tells two orders apart, hashable."""
        return self.url, json.dumps(self.storage_options, sort_keys=True, default=repr)

    def __hash__(self) -> int:
        return hash(self.key)

    @cached_property
    def folder(self) -> Path | None:
        """The local folder, or None elsewhere."""
        if self.url.startswith("file://"):
            return Path(self.url.removeprefix("file://"))
        return None if "://" in self.url or "::" in self.url else Path(self.url)


class Objects:
    """The objects of a store by their keys: a few operations that Zarr has no calls for."""

    def __init__(self, order: Order, *, read_only: bool = False) -> None:
        self.order = order
        self.store = _store(order, read_only)

    def get(self, key: str) -> bytes | None:
        """The bytes of an object, or None where there is none."""
        return self.get_all([key])[0]

    def get_all(self, keys: Iterable[str]) -> list[bytes | None]:
        """The bytes of several, many requests at a time."""
        if (folder := self.order.folder) is not None:
            return [_content(folder / key) for key in keys]
        from zarr.core.buffer import default_buffer_prototype

        async def one(key: str) -> bytes | None:
            found = await self.store.get(key, default_buffer_prototype())
            return None if found is None else found.to_bytes()

        return self._wait(_together(one, keys))

    def size(self, key: str) -> int:
        """Bytes of an object; 0 where there is none."""
        folder = self.order.folder
        try:
            if folder is not None:
                return (folder / key).stat().st_size
            return int(self._wait(self.store.getsize(key)))
        except (FileNotFoundError, NotADirectoryError):
            return 0

    def sizes(self, prefix: str) -> dict[str, int]:
        """Bytes of all objects right below a prefix, by their names there."""
        folder = self.order.folder
        if folder is not None:
            with suppress(FileNotFoundError), os.scandir(folder / prefix) as entries:
                return {entry.name: entry.stat().st_size for entry in entries if entry.is_file()}
            return {}

        async def found() -> dict[str, int]:
            names = [name async for name in self.store.list_dir(prefix)]
            keys = [f"{prefix}/{name}" if prefix else name for name in names]
            all_sizes = await _together(self.store.getsize, keys)
            return dict(zip(names, all_sizes, strict=True))

        return self._wait(found())

    def put(self, contents: Mapping[str, bytes]) -> None:
        """Write objects, each whole or not at all; one of no bytes is removed.

        When it returns they are on the disk, or with whoever keeps them, even if this machine goes.
        """
        if (folder := self.order.folder) is not None:
            # By ourselves: Zarr's store does not wait for the disk.
            for key, content in contents.items():
                _write(folder / key, content)
            return
        from zarr.core.buffer import default_buffer_prototype

        make = default_buffer_prototype().buffer.from_bytes

        async def one(key: str) -> None:
            if contents[key]:
                await self.store.set(key, make(contents[key]))
            else:
                await self.store.delete(key)

        self._wait(_together(one, contents))

    @contextmanager
    def alone(self) -> Iterator[None]:
        """One process of those that share a disk at a time; the others wait. Ends with the process.

        Stores far away, and systems without such locks, do not keep others away.
        """
        folder = self.order.folder
        if folder is None or flock is None:
            yield
            return
        if not folder.exists():
            folder.mkdir(parents=True, exist_ok=True)
        place = os.open(folder, os.O_RDONLY)
        try:
            with suppress(OSError):  # some disks of networks have none
                flock(place, LOCK_EX)
            yield
        finally:
            os.close(place)

    def sweep(self, *, all_of_them: bool) -> int:
        """Remove what killed processes left half written; of the last minute only at the end."""
        folder, removed = self.order.folder, 0
        for partial in [] if folder is None else folder.rglob("*.partial"):
            with suppress(OSError):
                if all_of_them or partial.stat().st_mtime < time.time() - _MINUTE:
                    partial.unlink()
                    removed += 1
        return removed

    def _wait(self, work: Coroutine[Any, Any, Result]) -> Result:
        from zarr.core.sync import sync

        return sync(work)


def _content(file: Path) -> bytes | None:
    try:
        return file.read_bytes()
    except (FileNotFoundError, NotADirectoryError):
        return None


def _write(file: Path, content: bytes) -> None:
    """Write a file under another name and rename it; nothing is left of one that fails."""
    if not content:
        file.unlink(missing_ok=True)
        return
    partial = file.with_name(f"{file.name}.{uuid4().hex}.partial")
    try:
        with partial.open("wb") as written:
            written.write(content)
            written.flush()
            os.fsync(written.fileno())
        try:
            partial.replace(file)
        except FileNotFoundError:  # Swept by another run of the same command that was done first
            _write(file, content)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise


async def _together(
    ask: Callable[[str], Coroutine[Any, Any, Result]], keys: Iterable[str]
) -> list[Result]:
    gate = asyncio.Semaphore(_AT_ONCE)

    async def passed(key: str) -> Result:
        async with gate:
            return await ask(key)

    return await asyncio.gather(*map(passed, keys))


def order_of(place: object, storage_options: Mapping[str, Any] | None = None) -> Order:
    """The order that a user's words stand for.

    Raises:
        ParameterError: The place is no text and no path, or options are no mapping.
    """
    if isinstance(place, Order):
        return place
    if not isinstance(place, str | os.PathLike) or not os.fspath(place):
        raise ParameterError(f"a data set is named by a folder or an address, found {place!r}")
    if storage_options is not None and not isinstance(storage_options, Mapping):
        raise ParameterError(f"storage options are a mapping, found {storage_options!r}")
    return Order(os.fspath(place), dict(storage_options or {}))


def _store(order: Order, read_only: bool) -> Store:
    try:
        from zarr.storage import FsspecStore, LocalStore
    except ImportError:
        raise MissingExtraError("zarr", "farm") from None
    if order.folder is not None:
        return LocalStore(order.folder, read_only=read_only)
    # Others write too, so what a listing said once is true no more.
    options = {"use_listings_cache": False, **order.storage_options}
    try:
        store = FsspecStore.from_url(order.url, storage_options=options, read_only=read_only)
    except ImportError as error:
        if order.url.startswith("s3"):
            raise MissingExtraError("s3fs", "s3") from None
        raise FileError(order.url, f"this address cannot be reached: {error}") from None
    except (ValueError, TypeError) as error:
        raise FileError(order.url, f"this address cannot be reached: {error}") from None
    store.fs = _Answering(store.fs)
    return store


class _Answering:
    """A file system of fsspec whose failures, of a dozen libraries, are all an `OSError`."""

    def __init__(self, fs: Any) -> None:
        self._fs = fs

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._fs, name)
        if not asyncio.iscoroutinefunction(found):
            return found

        async def asked(*arguments: Any, **options: Any) -> Any:
            try:
                return await found(*arguments, **options)
            except Exception as error:
                if not isinstance(error, FileNotFoundError):
                    self._fs.clear_instance_cache()  # Credentials may be mended before the next try
                if isinstance(error, OSError):
                    raise
                raise OSError(str(error) or type(error).__name__) from error

        return asked


@contextmanager
def naming_damage(order: Order, what: str, advice: str = _MAKE_AGAIN) -> Iterator[None]:
    """Errors of codecs and of metadata as one sentence, and those of the store as another."""
    with naming_store(order):
        try:
            yield
        except (OSError, ElastomorphError):
            raise
        except Exception as error:  # They are of a dozen kinds
            raise FormatError(
                order.url,
                f"{what} cannot be read ({str(error)[:100]}), what is stored is damaged: {advice}",
            ) from error


@contextmanager
def naming_store(order: Order) -> Iterator[None]:
    """Errors of a disk or a store as one sentence that says how to go on."""
    try:
        yield
    except OSError as error:
        said = " ".join((error.strerror or str(error)).split())[:300]
        raise FileError(
            order.url,
            f"this could not be read or written ({said}); what is finished is kept: when that is "
            "mended, the same command goes on",
        ) from error
