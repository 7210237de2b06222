"""Rigs that were built once, kept to be read again in a moment.

A cache is a convenience and nothing more: it is used only where its key, which names all that the
rig depends on (`elastomorph.io.rig_key`), is the one expected. One that is stale, damaged or cannot
be written is passed over in silence, and the rig is built from its files.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from elastomorph.errors import ElastomorphError, FileError
from elastomorph.io.kept_inputs import unnoted
from elastomorph.io.npz_members import open_npz, write_arrays
from elastomorph.io.rig_key import code_version, settings_digest
from elastomorph.io.rig_npz import rig_arrays, rig_of_members
from elastomorph.rig import Rig

__all__ = ["CACHE_SUFFIX", "RigCache", "user_cache_folder"]

# No suffix of a mesh, so that a cache beside the meshes of a rig is never taken for one.
CACHE_SUFFIX = ".rigcache"
_MOST_BYTES = 2 << 30


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

        Args:
            cache: True for the user's cache folder, a folder, or None or False for no cache.
            folder: The folder of the meshes.
            settings: All else that the rig depends on, but for the content of files.
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
        """The rig, where it was built from these contents by this code.

        Args:
            contents: Digest of each file it depends on.
            source: The file that its neutral came from.
        """
        # Whatever is wrong with a file that we can do without, we do without it.
        quiet = suppress(ElastomorphError, OSError, MemoryError)
        with quiet, unnoted(), open_npz(self.file) as members:
            if str(members.array("cache_key", "U", ())) == self._key(contents):
                rig = rig_of_members(self.file, members, source)
                with suppress(OSError):  # the time of last use decides which caches go first
                    os.utime(self.file)
                return rig
        return None

    def write(self, contents: Sequence[str], rig: Rig) -> None:
        """Keep a rig, if the folder allows.

        Args:
            contents: Digest of each file it depends on.
            rig: The rig built from them.
        """
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
