"""Whole files or none: reading with clear errors, and writing that never leaves half a file.

A file is written under a temporary name in the folder it goes to, flushed to the disk, and renamed
over the old one. Whoever opens the path sees the old file or the new one, nothing between. A
folder that does not exist is an error, not an invitation: a mistyped path should not grow folders.
A process that is killed cannot clean up after itself; the next one that writes there does.

What a command has read is not what it writes over. Files are known by their identity on the disk,
so links of either kind make no difference. Only the command line keeps its inputs: a program that
calls us may well mean what it says.
"""

from __future__ import annotations

import os
import re
import secrets
import shutil
import stat
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from hashlib import blake2s
from pathlib import Path
from shutil import disk_usage
from tempfile import TemporaryFile
from typing import BinaryIO, NoReturn

from elastomorph.errors import FileError, FormatError, ParameterError

# Temporary files and folders that a later run recognises, and removes where a run was killed.
#
# Their names tell which process made them: ``.elastomorph-MACHINE-PROCESS-RANDOM.obj``. What a
# process of this machine left behind that is no longer running goes at once; what another machine
# left on a shared disk goes when it is a day old, for nobody here can ask whether that one still
# writes.

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


_GZIP = b"\x1f\x8b\x08"


Identity = tuple[int, int]

# Of each command that is running, the innermost last, what it has read and what it has written; of
# the process, for threads read too.
_noted: list[tuple[set[Identity], set[Identity]]] = []


def require_name(path: object) -> None:
    """Check that what should name a file can."""
    if not isinstance(path, str | os.PathLike):
        raise ParameterError(f"a file is named by a text or a Path, found {type(path).__name__}")


def read_bytes(path: str | Path) -> bytes:
    """The content of an ordinary file, not compressed; devices and pipes may never end."""
    with opened(path) as file:
        content = file.read()
    if content.startswith(_GZIP):
        raise FormatError(path, "this file is compressed with gzip; unpack it first")
    return content


@contextmanager
def opened(path: str | Path) -> Iterator[BinaryIO]:
    """A file open for reading, for formats that jump to and fro in it."""
    require_name(path)
    with ExitStack() as stack:
        try:
            mode = Path(path).stat().st_mode
            if stat.S_ISDIR(mode):
                raise FileError(path, "this is a folder; name a file in it")
            if not stat.S_ISREG(mode):
                raise FileError(path, "this is a device or a pipe; expected an ordinary file")
            file = stack.enter_context(Path(path).open("rb"))
            _note_input(os.fstat(file.fileno()))
        except (OSError, ValueError) as error:
            _refuse_reading(path, error)
        try:
            yield file
        except OSError as error:
            _refuse_reading(path, error)


def made_folder(path: str | Path) -> Path:
    """A folder for results that was asked for by name, made where it is missing."""
    folder = Path(path)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise FileError(path, "this is a file; name a folder for the results") from None
    except (OSError, ValueError) as error:
        _refuse_writing(path, error)
    return folder


def require_folder(path: str | Path) -> Path:
    """Refuse a folder for results that could not be made or written in, without making it.

    Returns:
        It, or the nearest of the folders above it that is there.

    Raises:
        FileError: It is a file, or may not be written in.
    """
    there = next(own for own in (Path(path), *Path(path).absolute().parents) if own.exists())
    if not is_folder(there):
        which = "this" if there == Path(path) else there
        raise FileError(path, f"{which} is a file; name a folder for the results")
    try:
        TemporaryFile(dir=there).close()
    except OSError as error:
        raise FileError(
            path, f"{there} cannot be written in ({error.strerror}); name another output"
        ) from error
    return there


def is_folder(path: str | Path) -> bool:
    """Whether a path is a folder; False for one that cannot be, such as one that is too long."""
    try:
        return Path(path).is_dir()
    except (OSError, ValueError):
        return False


def is_file(path: str | Path) -> bool:
    """Whether a path is an ordinary file; False for one that cannot be."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        return False


def same_file(path: str | Path, other: str | Path) -> bool:
    """Whether two paths are one file or folder on the disk; False where one is not there."""
    try:
        return Path(path).samefile(other)
    except (OSError, ValueError):
        return False


def size_of(path: str | Path) -> int:
    """Bytes of a file; 0 where there is none, which is for its reader to complain about."""
    try:
        return Path(path).stat().st_size
    except (OSError, ValueError):
        return 0


@contextmanager
def replacing(path: str | Path) -> Iterator[BinaryIO]:
    """A file to write that takes the place of ``path`` once all of it is written.

    On any error or interrupt nothing is left behind and the old file stays. Its folder must exist.
    Where the path is a link, the file it points to is replaced and the link stays.
    """
    with _temporary_beside(path) as temporary, temporary.open("wb") as file:
        yield file
        file.flush()
        os.fsync(file.fileno())


@contextmanager
def replacing_path(path: str | Path) -> Iterator[Path]:
    """As `replacing`, for libraries that want a name to write to instead of an open file.

    The temporary name lies in the same folder and has the suffix of ``path``. It exists as an
    empty file when it is handed over.
    """
    with _temporary_beside(path) as temporary:
        yield temporary


def require_writable(path: str | Path) -> None:
    """Refuse a file that could not be written, for what is written after long work only.

    Raises:
        FileError: And why.
    """
    try:
        final = Path(path).resolve()
        _require_replaceable(path, final)
        TemporaryFile(dir=final.parent).close()
    except (OSError, ValueError, RuntimeError) as error:
        _refuse_writing(path, error)


def require_room(path: str | Path, size: int, what: str) -> None:
    """Refuse a file, or numbered files, of at least so many bytes that its disk does not hold."""
    try:
        free = disk_usage(Path(path).resolve().parent).free
    except (OSError, ValueError, RuntimeError):
        return  # whoever writes there says why it cannot be
    if size > free:
        raise FileError(
            path,
            f"{what} take {size / 1e9:,.1f} GB, and {free / 1e9:,.1f} GB are free on that disk; "
            "write fewer, or name another",
        )


@contextmanager
def _temporary_beside(path: str | Path) -> Iterator[Path]:
    try:
        final = Path(path).resolve()
        _require_no_input(path, final)
        kept_mode = _require_replaceable(path, final)
        remove_orphans(final.parent)
        temporary = temporary_name(final)
    except (OSError, ValueError, RuntimeError) as error:
        _refuse_writing(path, error)
    try:
        # 0o666 is narrowed by the umask, as for any file a user makes; tempfile's 0o600 is not
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))
        yield temporary
        if kept_mode is not None:
            temporary.chmod(kept_mode)
        temporary.replace(final)
        _note_output(final)
    except OSError as error:
        _refuse_writing(path, error)
    except FileError as error:
        if error.path != temporary:
            raise
        # a writer that was handed the temporary name complains about a file no one knows
        problem = str(error).removeprefix(f"{temporary}: ")
        raise type(error)(path, problem, line=error.line) from error
    finally:
        with suppress(OSError):  # gone already where the rename succeeded
            temporary.unlink(missing_ok=True)


def _require_replaceable(path: str | Path, final: Path) -> int | None:
    """Check that ``final`` may be replaced; returns the mode of the old file, if there is one."""
    if not final.parent.is_dir():
        raise FileError(
            path, f"the folder {final.parent} does not exist; create it first or name another"
        )
    try:
        mode = final.stat().st_mode
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(mode):
        raise FileError(path, "this is a folder; name a file to write in it")
    if not stat.S_ISREG(mode):
        raise FileError(path, "this is a device or a pipe; only an ordinary file can be replaced")
    if not os.access(final, os.W_OK):
        raise FileError(path, "the file is write-protected; name another or lift the protection")
    return stat.S_IMODE(mode)


def _refuse_reading(path: str | Path, error: OSError | ValueError) -> NoReturn:
    if isinstance(error, FileNotFoundError):
        parts, folder = Path(path).parts, Path(path).parent
        problem = "there is no such file; check the name and the folder it is looked for in"
        if parts[:1] and parts[0].startswith("~"):
            problem = f"'{parts[0]}' stands for a home folder in a shell only; write the whole path"
        elif not folder.exists():
            problem = f"the folder {folder} does not exist"
        raise FileError(path, problem) from None
    if isinstance(error, PermissionError):
        raise FileError(path, "you have no permission to read this file") from None
    raise FileError(path, f"the file cannot be read: {_reason(error)}") from error


def _refuse_writing(path: str | Path, error: Exception) -> NoReturn:
    if isinstance(error, PermissionError):
        raise FileError(path, "you have no permission to write in this folder") from None
    raise FileError(path, f"the file cannot be written: {_reason(error)}") from error


def _reason(error: Exception) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error)


@contextmanager
def inputs_kept() -> Iterator[None]:
    """Refuse, from here on, to write over a file that was read."""
    _noted.append((set(), set()))
    try:
        yield
    finally:
        _noted.pop()


@contextmanager
def unnoted() -> Iterator[None]:
    """Read and write what is nobody's input, such as a cache."""
    before = _noted[:]
    _noted.clear()
    try:
        yield
    finally:
        _noted[:] = before


def _note_input(found: os.stat_result) -> None:
    """Remember a file that is being read, unless this command has written it."""
    if _noted and _identity(found) not in _noted[-1][1]:
        _noted[-1][0].add(_identity(found))


def _note_output(final: Path) -> None:
    """Remember a file that was written: it may be read and written again."""
    if _noted:
        with suppress(OSError):
            _noted[-1][1].add(_identity(final.stat()))


def _require_no_input(path: str | Path, final: Path) -> None:
    """Refuse to write over a file that was read."""
    with suppress(OSError):
        if _noted and _identity(final.stat()) in _noted[-1][0]:
            raise FileError(
                path,
                "this file was read as an input and is not written over; name another output, or "
                "add --overwrite",
            )


def _identity(found: os.stat_result) -> Identity:
    return found.st_dev, found.st_ino
