"""What a killed run leaves behind is recognised and removed; what a running one needs is not."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from elastomorph.io import atomic
from elastomorph.io.atomic import remove_orphans, temporary_folder, temporary_name

posix = pytest.mark.skipif(os.name != "posix", reason="only POSIX can ask whether a process runs")


@pytest.fixture(autouse=True)
def _look_again() -> None:
    remove_orphans.cache_clear()


def left_by(program: str, folder: Path) -> Path:
    """What a process of its own made in a folder before it ended without cleaning up."""
    text = f"import os, sys\nfrom pathlib import Path\n{program}\nsys.stdout.flush()\nos._exit(0)"
    environment = os.environ | {"TMPDIR": str(folder)}
    done = subprocess.run(
        [sys.executable, "-c", text, str(folder)], capture_output=True, text=True, env=environment
    )
    assert done.returncode == 0, done.stderr
    return Path(done.stdout.strip())


FILE = """
from elastomorph.io.atomic import temporary_name
place = temporary_name(Path(sys.argv[1]) / "face.obj")
place.write_text("half")
print(place)
"""
FOLDER = """
from elastomorph.io.atomic import temporary_folder
context = temporary_folder()
place = context.__enter__()
(place / "content.npz").write_text("half")
print(place)
"""


@posix
@pytest.mark.parametrize("program", [FILE, FOLDER])
def test_what_a_dead_process_left_goes_with_the_next_run(tmp_path: Path, program: str) -> None:
    left = left_by(program, tmp_path)
    assert left.exists()
    remove_orphans(tmp_path)
    assert not left.exists()


def test_what_this_process_is_writing_stays(tmp_path: Path) -> None:
    mine = temporary_name(tmp_path / "face.obj")
    mine.write_text("half")
    remove_orphans(tmp_path)
    assert mine.exists()
    assert mine.suffix == ".obj"
    assert mine.name.startswith(".")


def test_what_another_machine_writes_stays_for_a_day(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(atomic, "_machine", lambda: "0123abcd")
    theirs = temporary_name(tmp_path / "face.obj")
    monkeypatch.undo()
    theirs.write_text("half")
    remove_orphans(tmp_path)
    assert theirs.exists()
    yesterday = time.time() - 25 * 3600
    os.utime(theirs, (yesterday, yesterday))
    remove_orphans.cache_clear()
    remove_orphans(tmp_path)
    assert not theirs.exists()


def test_files_of_other_names_stay(tmp_path: Path) -> None:
    names = ["face.obj", ".elastomorph-notes.txt", "elastomorph.toml", ".elastomorph-1-2-3.obj"]
    for name in names:
        (tmp_path / name).write_text("mine")
        os.utime(tmp_path / name, (0, 0))
    remove_orphans(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


def test_a_temporary_folder_is_gone_at_the_end(tmp_path: Path) -> None:
    with temporary_folder() as folder:
        (folder / "inside.txt").write_text("here")
    assert not folder.exists()


def test_a_folder_that_does_not_exist_has_no_orphans(tmp_path: Path) -> None:
    remove_orphans(tmp_path / "missing")
