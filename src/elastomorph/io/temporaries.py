"""Temporary files and folders that a later run recognises, and removes where a run was killed.

Their names tell which process made them: ``.elastomorph-MACHINE-PROCESS-RANDOM.obj``. What a
process of this machine left behind that is no longer running goes at once; what another machine
left on a shared disk goes when it is a day old, for nobody here can ask whether that one still
writes.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from hashlib import blake2s
from pathlib import Path

_NAME = re.compile(r"\.?elastomorph-(?P<machine>[0-9a-f]{8})-(?P<process>\d{1,10})-[0-9a-f]{16}\b")
_DAY = 24 * 3600.0


def temporary_name(final: Path) -> Path:
    """A name beside a file that nobody has, with its suffix."""
    return final.with_name(f".{_own_stem()}{final.suffix}")


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """A folder of one's own where the system keeps temporary ones, gone at the end."""
    place = Path(tempfile.gettempdir())
    remove_orphans(place)
    folder = place / _own_stem()
    folder.mkdir(mode=0o700)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


@cache
def remove_orphans(folder: Path) -> None:
    """Remove what killed runs left in a folder; looked at once a process, for folders are large."""
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            made = _NAME.match(entry.name)
            if made and _is_orphan(entry, made["machine"], int(made["process"])):
                if entry.is_dir(follow_symlinks=False):
                    shutil.rmtree(entry.path, ignore_errors=True)
                else:
                    with suppress(OSError):  # somebody else's, or gone in the meantime
                        Path(entry.path).unlink()


def _own_stem() -> str:
    return f"elastomorph-{_machine()}-{os.getpid()}-{secrets.token_hex(8)}"


def _is_orphan(entry: os.DirEntry[str], machine: str, process: int) -> bool:
    with suppress(OSError):
        if time.time() - entry.stat(follow_symlinks=False).st_mtime > _DAY:
            return True
    return machine == _machine() and not _is_running(process)


def _is_running(process: int) -> bool:
    if os.name != "posix":  # asking elsewhere would end the process
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):
        return True
    return True


@cache
def _machine() -> str:
    """Eight digits for the processes that can see each other: a machine since it was started.

    A container counts processes of its own, so it is a machine of its own.
    """
    known = [str(os.uname().nodename) if hasattr(os, "uname") else os.environ.get("COMPUTERNAME")]
    for fact in ("/proc/sys/kernel/random/boot_id", "/proc/self/ns/pid"):
        with suppress(OSError):
            place = Path(fact)
            known.append(str(place.readlink()) if place.is_symlink() else place.read_text())
    return blake2s(repr(known).encode(), digest_size=4).hexdigest()
