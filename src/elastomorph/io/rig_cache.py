"""Rigs that were built once, kept to be read again in a moment.

A cache is a convenience and nothing more: it is used only where its key, which names all that the
rig depends on (the content of its files, the method, and the code that applied it), is the one
expected. One that is stale, damaged or cannot be written is passed over in silence, and the rig is
built from its files.

Contents are hashed, not looked up by date and size: a copied, restored or synchronised file may
keep both while it changes. Hashing is far quicker than parsing, and threads share it.
"""

from __future__ import annotations

import hashlib
import json
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from elastomorph.curves import CurveNetwork
from elastomorph.errors import ElastomorphError, FileError
from elastomorph.io.atomic import opened, unnoted
from elastomorph.io.npz.members import open_npz, write_arrays
from elastomorph.io.npz.rig import rig_arrays, rig_of_members
from elastomorph.rig import Rig

# No suffix of a mesh, so that a cache beside the meshes of a rig is never taken for one.
CACHE_SUFFIX = ".rigcache"
# Files of these formats may name others, buffers and layers, whose content no key would know.
_NAMING_OTHERS = (".gltf", ".usd", ".usda", ".usdc")
_MOST_BYTES = 2 << 30
_MOST_THREADS = 8
_BLOCK = 1 << 20


def user_cache_folder() -> Path | None:
    r"""Where caches of this user go on this system; None where the user has no home.

    ``$XDG_CACHE_HOME/elastomorph`` or ``~/.cache/elastomorph``; ``~/Library/Caches/elastomorph``
    on macOS and ``%LOCALAPPDATA%\elastomorph\Cache`` on Windows.
    """
    named = Path(os.environ.get("XDG_CACHE_HOME", ""))
    if named.is_absolute():
        return named / "elastomorph"
    local = os.environ.get("LOCALAPPDATA")
    if sys.platform == "win32" and local:
        return Path(local) / "elastomorph" / "Cache"
    with suppress(RuntimeError):
        home = Path.home()
        return home / ("Library/Caches" if sys.platform == "darwin" else ".cache") / "elastomorph"
    return None


@dataclass(frozen=True)
class RigCache:
    """The place of one rig in a cache folder: one file for each folder of meshes and method.

    Attributes:
        file: The file; there or not.
        settings: Digest of the method and its settings.
    """

    file: Path
    settings: str

    @classmethod
    def of(
        cls, cache: bool | str | Path | None, folder: Path, settings: Sequence[object]
    ) -> RigCache | None:
        """The place for a rig, or None where it is not to be cached.

        ``cache`` is True for the user's cache folder, or a folder; ``settings`` are all that the
        rig depends on but the content of files.
        """
        if cache is None or cache is False:
            return None
        place = user_cache_folder() if cache is True else Path(cache)
        digest = settings_digest(*settings)
        if place is None or digest is None:
            return None
        try:
            whole = folder.resolve()
        except (OSError, RuntimeError):
            return None
        slot = settings_digest(str(whole), digest)
        return cls(place / f"{whole.name or 'rig'}-{slot}{CACHE_SUFFIX}", digest)

    def read(self, contents: Sequence[str], source: Path) -> Rig | None:
        """The rig, where this code built it from files of these digests; ``source`` its neutral."""
        # Whatever is wrong with a file that we can do without, we do without it.
        quiet = suppress(ElastomorphError, OSError, MemoryError)
        with quiet, unnoted(), open_npz(self.file) as members:
            if str(members.array("cache_key", "U", ())) == self._key(contents):
                rig = rig_of_members(members, source)
                with suppress(OSError):  # the time of last use decides which caches go first
                    os.utime(self.file)
                return rig
        return None

    def write(self, contents: Sequence[str], rig: Rig) -> None:
        """Keep a rig built from files of these digests, if the folder allows."""
        arrays = {"cache_key": np.array(self._key(contents)), **rig_arrays(rig)}
        with suppress(FileError, OSError), unnoted():
            self.file.parent.mkdir(parents=True, exist_ok=True)
            write_arrays(self.file, arrays)
            self._drop_oldest()

    def _key(self, contents: Sequence[str]) -> str:
        return f"{code_version()} {settings_digest(self.settings, list(contents))}"

    def _drop_oldest(self) -> None:
        """Delete the caches used longest ago until the rest, with ours, take 2 GiB at most."""
        others = [file for file in self.file.parent.glob(f"*{CACHE_SUFFIX}") if file != self.file]
        known = [(file.stat().st_mtime_ns, file.stat().st_size, file) for file in others]
        left = _MOST_BYTES - self.file.stat().st_size
        for _, size, file in sorted(known, reverse=True):
            left -= size
            if left < 0:
                file.unlink(missing_ok=True)


def read_or_build(
    place: RigCache | None,
    files: Mapping[Path, str],
    what: object,
    build: Callable[[], Rig],
    say: Callable[[str], None],
) -> Rig:
    """The rig that is kept of files, the neutral first, or else the one that is built now and kept.

    ``files`` have the names that stand for them in the key; ``what`` is how the user named the rig.
    """
    if place is None or any(file.suffix.lower() in _NAMING_OTHERS for file in files):
        return build()
    contents = _contents(files)
    known = place.read(contents, next(iter(files)))
    if known is not None:
        say(f"{len(known)} targets of {what} read from {place.file}")
        return known
    rig = build()
    # A file that changed while it was read must not be remembered under its content before.
    if _contents(files) == contents:
        place.write(contents, rig)
    return rig


def _contents(files: Mapping[Path, str]) -> tuple[str, ...]:
    """Name and digest of the content of each file."""
    digests = content_digests([*files])
    return tuple(f"{name}:{own}" for name, own in zip(files.values(), digests, strict=True))


def content_digests(files: Sequence[Path]) -> tuple[str, ...]:
    """The BLAKE2b digest of the content of each file."""
    with ThreadPoolExecutor(min(_MOST_THREADS, os.cpu_count() or 1)) as threads:
        return tuple(threads.map(_digest_of_file, files))


def settings_digest(*settings: object) -> str | None:
    """A digest that differs wherever settings do, or None where text cannot stand for them."""
    try:
        return _digest(json.dumps(_described(settings), ensure_ascii=True).encode())
    except _NotDescribableError:
        return None


def installed_version(package: str) -> str:
    """The version of a package that is installed, empty where it is not."""
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


@cache
def code_version() -> str:
    """Names the code of this package, so that what another version made is made anew."""
    released = installed_version("elastomorph")
    # A checkout changes without a new version number, so the sources themselves are hashed.
    digest = hashlib.blake2b(f"{released} numpy {np.__version__}".encode(), digest_size=16)
    for source in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()


class _NotDescribableError(TypeError):
    """A setting whose value text cannot stand for."""


def _described(value: object) -> Any:
    """The value as lists and text, different for different values."""
    if value is None or isinstance(value, bool | str):
        return value
    if isinstance(value, np.generic):
        return _described(value.item())
    if isinstance(value, int):
        return ["int", str(value)]
    if isinstance(value, float):
        return ["float", value.hex()]
    if isinstance(value, Path):
        return ["path", str(value)]
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufU":
        return ["array", value.dtype.str, value.shape, _digest(value.tobytes())]
    if isinstance(value, CurveNetwork):
        return ["curves", value.vertex_count, [_described(curve) for curve in value]]
    if is_dataclass(value) and not isinstance(value, type):
        own = [[field.name, _described(getattr(value, field.name))] for field in fields(value)]
        return ["object", type(value).__qualname__, own]
    if isinstance(value, Mapping):
        return ["mapping", [[_described(key), _described(own)] for key, own in value.items()]]
    if isinstance(value, Sequence) and not isinstance(value, bytes | bytearray | memoryview):
        return ["list", [_described(item) for item in value]]
    raise _NotDescribableError(f"{type(value).__name__} cannot be described")


def _digest(content: bytes) -> str:
    return hashlib.blake2b(content, digest_size=16).hexdigest()


def _digest_of_file(path: Path) -> str:
    digest = hashlib.blake2b(digest_size=16)
    with opened(path) as file:
        while block := file.read(_BLOCK):
            digest.update(block)
    return digest.hexdigest()
