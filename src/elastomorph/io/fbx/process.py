"""Runs the FBX worker: a crash, a hang or a flood of memory in it becomes one clear error here."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path

from elastomorph.errors import FileError, FormatError, MissingExtraError
from elastomorph.io.atomic import opened
from elastomorph.io.fbx.worker import REFUSED
from elastomorph.io.npz_members import NpzMembers, open_npz

__all__ = ["extracted"]

# A head of 4 MB takes a quarter of a second and 0.1 GB; these are limits for what went wrong.
_SECONDS, _BYTES_A_SECOND = 60.0, 1e6
_BYTES, _EXPANSION = 3 << 30, 40

_WORKER = Path(__file__).with_name("worker.py")

_ADVICE = (
    "export it again as binary FBX 2014 or later from the program it was made with, or as another "
    "format"
)


@contextmanager
def extracted(path: str | Path) -> Iterator[NpzMembers]:
    """The meshes and blend shapes of an FBX file as the arrays that the worker wrote.

    Raises:
        MissingExtraError: ufbx is not installed.
        FileError: The file is missing or cannot be read.
        FormatError: It is not FBX, or reading it failed, crashed or took too long.
    """
    if find_spec("ufbx") is None:
        raise MissingExtraError("ufbx", "fbx")
    with opened(path) as file:
        size = file.seek(0, os.SEEK_END)
    with tempfile.TemporaryDirectory(prefix="elastomorph-") as folder:
        archive = Path(folder) / "content.npz"
        _run(path, archive, size)
        try:
            with open_npz(archive) as members:
                yield members
        except FileError as error:
            if error.path != archive:
                raise
            problem = str(error).removeprefix(f"{archive}: ")
            raise FormatError(path, f"its content makes no sense: {problem}; {_ADVICE}") from error


def _run(path: str | Path, archive: Path, size: int) -> None:
    if not sys.executable:
        raise FileError(
            path,
            "FBX is read in a process of its own, but this Python does not know its interpreter; "
            "convert the file with the command 'elastomorph' first",
        )
    seconds = _SECONDS + size / _BYTES_A_SECOND
    try:
        # By its path, so that the worker imports NumPy and ufbx but not this whole package.
        done = subprocess.run(
            [
                *(sys.executable, "-P", str(_WORKER)),
                *(str(Path(path).absolute()), str(archive), str(_BYTES + _EXPANSION * size)),
            ],
            env=_environment(),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            timeout=seconds,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise FormatError(
            path, f"reading it took longer than {seconds:.0f} seconds and was stopped; {_ADVICE}"
        ) from None
    except OSError as error:
        raise FileError(path, f"no process could be started to read it: {error}") from error
    said = done.stderr.decode("utf-8", "replace").strip()
    if done.returncode == REFUSED:
        raise FormatError(
            path,
            f"it cannot be read as FBX ({said}): it is damaged, cut off or another format; "
            f"{_ADVICE}",
        )
    if done.returncode != 0 or not archive.is_file():
        raise FormatError(
            path,
            f"the reader of FBX files broke on it ({_death(done.returncode, said)}); {_ADVICE}",
        )


def _environment() -> dict[str, str]:
    """Ours, with the modules that this process finds and one thread for what needs no more."""
    found = os.pathsep.join(place for place in sys.path if place)
    return {**os.environ, "PYTHONPATH": found, "OPENBLAS_NUM_THREADS": "1"}


def _death(status: int, said: str) -> str:
    if status < 0:
        try:
            return signal.Signals(-status).name
        except ValueError:
            return f"signal {-status}"
    return said.splitlines()[-1][:200] if said else f"exit status {status}"
