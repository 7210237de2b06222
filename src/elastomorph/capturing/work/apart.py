"""Cameras are solved in a process of its own: its libraries may end it, or keep memory, as they do.

What goes there and comes back are the arrays that stages leave too; multiprocessing would run the
script that called us once more. What it says on the way comes line by line, and where it is told to
stop, or its parent is gone, it ends at once, in the middle of whatever its libraries do.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from elastomorph import errors
from elastomorph.capturing.work.progress import StageSay
from elastomorph.capturing.work.stages import packed, unpacked
from elastomorph.errors import CaptureError, ElastomorphError, FileError
from elastomorph.io.atomic import temporary_folder, unnoted
from elastomorph.io.isolated import own_process
from elastomorph.io.npz.members import open_npz, write_arrays

_ROOM = "elastomorph.capturing"
_GIVEN, _FOUND, _PROBLEM, _NOISE = "given.npz", "found.npz", "problem.json", "noise.txt"
_REFUSED = 3


def done_apart(task: str, given: Mapping[str, Any], say: StageSay) -> Any:
    """What a function of this room makes, in a process of its own.

    Args:
        task: Module and function, as ``cameras.cameras.solve_pose``.
        given: Its arguments by name, beside ``say``: what `packed` takes.
        say: Told what it says.

    Raises:
        ElastomorphError: That it raised, or a CaptureError where the process broke.
    """
    if not sys.executable:  # a Python within another program
        return _function(task)(**given, say=say)
    with temporary_folder() as folder, unnoted():
        write_arrays(folder / _GIVEN, packed(dict(given)))
        status = _run(task, folder, say)
        if status == _REFUSED:
            raise _rebuilt(json.loads((folder / _PROBLEM).read_text(encoding="utf-8")))
        if status != 0:
            noise = (folder / _NOISE).read_bytes()[-2000:].decode("utf-8", "backslashreplace")
            raise CaptureError(_broken(status, noise))
        with open_npz(folder / _FOUND) as members:
            return unpacked(members)


def _run(task: str, folder: Path, say: StageSay) -> int:
    """The exit status of the process."""
    # What it leaves where files are temporary goes with the folder, however it ends.
    temporary = dict.fromkeys(("TMPDIR", "TEMP", "TMP"), str(folder))
    command, environment = own_process(__name__)
    with (folder / _NOISE).open("wb") as noise:
        process = subprocess.Popen(
            [*command, task, str(folder)],
            env=environment | temporary,
            stdin=subprocess.PIPE,  # its end tells the process that this one is gone
            stdout=subprocess.PIPE,
            stderr=noise,
            text=True,
            encoding="utf-8",
        )
    with process:
        try:
            for line in process.stdout or ():
                part, _, text = line.strip().partition(" ")
                say(text, float(part))
            return process.wait()
        except BaseException:
            process.kill()
            raise


def _broken(status: int, noise: str) -> str:
    names = {-sign: sign.name for sign in signal.Signals}
    words = noise.strip().splitlines()
    how = names.get(status, f"status {status}")
    said = f", after it said: {words[-1][:200]}" if words else ""
    memory = "; it may have had too little memory" if how == "SIGKILL" else ""
    return (
        f"the process that solves cameras ended with {how}{said}{memory}; run the same command "
        "again, and if it ends so again, with fewer or smaller photographs of this pose"
    )


def _rebuilt(problem: Mapping[str, Any]) -> ElastomorphError:
    kind = getattr(errors, str(problem["kind"]), CaptureError)
    if issubclass(kind, FileError):
        path = str(problem["path"])
        return kind(path, str(problem["said"]).removeprefix(f"{path}: "))
    return CaptureError(str(problem["said"]))


def _function(task: str) -> Any:
    module, _, name = task.rpartition(".")
    return getattr(importlib.import_module(f"{_ROOM}.{module}"), name)


def _end_with_parent() -> None:
    while os.read(0, 1):  # not by sys.stdin, which the end of Python waits for
        pass
    os._exit(1)


def _serve(task: str, folder: Path) -> int:
    """Do a task; the exit status."""

    def say(text: str, part: float) -> None:
        words = " ".join(text.split())
        sys.stdout.write(f"{part} {words}\n")
        sys.stdout.flush()

    try:
        with open_npz(folder / _GIVEN) as members:
            given = unpacked(members)
        write_arrays(folder / _FOUND, packed(_function(task)(**given, say=say)))
    except ElastomorphError as error:
        problem = {
            "kind": type(error).__name__,
            "said": str(error),
            "path": str(getattr(error, "path", "")),
        }
        (folder / _PROBLEM).write_text(json.dumps(problem), encoding="utf-8")
        return _REFUSED
    return 0


def main() -> None:
    """Serve the process that started this one."""
    # Ctrl-C reaches all processes of a terminal; the parent ends this one.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    sys.stdout.reconfigure(encoding="utf-8")  # type: ignore[union-attr]
    status = 1
    try:
        status = _serve(sys.argv[1], Path(sys.argv[2]))
        sys.stdout.flush()
    except BaseException as error:  # only its last words are shown
        sys.stderr.write(f"{type(error).__name__}: {error}")
        sys.stderr.flush()
    finally:
        os._exit(status)  # the end of Python may fail in libraries after all is written


if __name__ == "__main__":
    main()
