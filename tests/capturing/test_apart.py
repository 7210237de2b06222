"""A stage in a process of its own: what it finds and says comes back, and how it ended."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from elastomorph.capturing.geometry import Similarity
from elastomorph.capturing.work import apart
from elastomorph.capturing.work.apart import done_apart
from streams import wait

TASKS = """
import os, signal, sys, time
from elastomorph.errors import CaptureError, FormatError

def doubled(value, say):
    say("doubling ·", 0.5)
    return {"twice": value, "scale": 2 * value.scale}

def refused(say):
    raise CaptureError("no overlap: take more")

def damaged(say):
    raise FormatError("a/b.jpg", "it is cut off")

def mistaken(say):
    raise ZeroDivisionError("in a library")

def killed(say):
    os.kill(os.getpid(), signal.SIGABRT)

def littering(say):
    import tempfile
    return {"place": tempfile.mkdtemp()}

def endless(place, say):
    with open(place, "w") as file:
        file.write(str(os.getpid()))
    say("begun", 0.0)
    while True:
        time.sleep(0.01)
"""


@pytest.fixture(autouse=True)
def tasks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Modules of a room of tests stand for those of ours."""
    room = tmp_path / "room_of_tests"
    room.mkdir()
    (room / "__init__.py").touch()
    (room / "tasks.py").write_text(TASKS)
    # The module is run by its name, so the child has a copy that looks in the other room.
    source = Path(apart.__file__).read_text()
    (room / "worker.py").write_text(source.replace('"elastomorph.capturing"', '"room_of_tests"'))
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(apart, "__name__", "room_of_tests.worker")
    monkeypatch.setattr(apart, "_ROOM", "room_of_tests")


def alive(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().split()[2] != "Z"
    except (FileNotFoundError, ProcessLookupError):  # before it was opened, or read
        return False


def test_what_it_makes_and_says_comes_back() -> None:
    said: list[tuple[str, float]] = []
    value = Similarity(3.0, np.eye(3), np.ones(3))
    found = done_apart("tasks.doubled", {"value": value}, lambda *words: said.append(words))
    assert found["scale"] == 6.0
    np.testing.assert_array_equal(found["twice"].shift, np.ones(3))
    assert said == [("doubling ·", 0.5)]


def test_what_it_leaves_where_files_are_temporary_goes_with_it() -> None:
    place = Path(done_apart("tasks.littering", {}, lambda *_: None)["place"])
    assert place.parent.name.startswith("elastomorph-")
    assert not place.parent.exists()


def test_its_errors_are_ours() -> None:
    with pytest.raises(em.CaptureError, match=r"^no overlap: take more$"):
        done_apart("tasks.refused", {}, lambda *_: None)
    with pytest.raises(em.FormatError, match=r"^a/b\.jpg: it is cut off$") as caught:
        done_apart("tasks.damaged", {}, lambda *_: None)
    assert caught.value.path == Path("a/b.jpg")


@pytest.mark.skipif(sys.platform == "win32", reason="signals have no names there")
def test_its_death_is_one_sentence() -> None:
    with pytest.raises(em.CaptureError, match=r"cameras ended with SIGABRT.*; run the same"):
        done_apart("tasks.killed", {}, lambda *_: None)
    with pytest.raises(em.CaptureError, match="ended with status 1, after it said: Zero"):
        done_apart("tasks.mistaken", {}, lambda *_: None)


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs /proc")
def test_an_interrupt_ends_it_at_once(tmp_path: Path) -> None:
    place = tmp_path / "process"

    def interrupt(text: str, part: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        done_apart("tasks.endless", {"place": str(place)}, interrupt)
    assert not alive(int(place.read_text()))


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="needs /proc")
def test_it_ends_with_its_parent(tmp_path: Path) -> None:
    from children import started

    place = tmp_path / "process"
    program = (
        "import sys\nfrom elastomorph.capturing.work import apart\n"
        "apart.__name__, apart._ROOM = 'room_of_tests.worker', 'room_of_tests'\n"
        f"apart.done_apart('tasks.endless', {{'place': {str(place)!r}}}, lambda *_: print(1))\n"
    )
    paths = os.pathsep.join([str(tmp_path), *(each for each in sys.path if each)])
    environment = os.environ | {"PYTHONPATH": paths, "PYTHONUNBUFFERED": "1"}
    with started("-c", program, stdout=-1, env=environment) as parent:
        assert parent.stdout is not None
        parent.stdout.readline()
        parent.kill()
    process = int(place.read_text())
    wait(lambda: not alive(process))


def test_within_another_program_it_is_done_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "")
    value = Similarity(3.0, np.eye(3), np.ones(3))
    found = done_apart("tasks.doubled", {"value": value}, lambda *_: None)
    assert found["twice"] is value
