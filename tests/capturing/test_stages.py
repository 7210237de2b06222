"""A working folder: what is whole is kept, what changed is made again, one process at a time."""

from __future__ import annotations

import signal
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from children import started
from elastomorph.capturing.geometry import Camera, Similarity
from elastomorph.capturing.work.stages import Made, WorkingFolder, content_digest, packed
from elastomorph.errors import FileError

CAMERA = Camera("a.jpg", (750, 1000), 900.5, np.array([374.5, 499.5]), -0.1, np.eye(3), np.ones(3))


def equal(a: object, b: object) -> bool:
    return content_digest(packed(a)) == content_digest(packed(b))


def test_a_result_comes_back_as_it_was(tmp_path: Path) -> None:
    result = {
        "cameras": (CAMERA, replace(CAMERA, name="b ü.jpg")),
        "points": np.random.default_rng(0).normal(size=(5, 3)),
        "looks": np.arange(6, dtype=np.float32).reshape(2, 3),
        "masks": [np.array([True, False]), None],
        "similarity": Similarity(2.0, np.eye(3), np.zeros(3)),
        "figures": {"rms": 0.1, "worst": float("inf"), "count": 3, "good": True},
        7: Path("a/b.jpg"),
    }
    with WorkingFolder(tmp_path / "work") as working:
        made: Made[dict[object, object]] = working.made("cameras/smile", {}, lambda: result, 1)
    found = made.read()
    assert equal(found, result)
    assert isinstance(found["cameras"], tuple)
    assert found["cameras"][1].name == "b ü.jpg"  # type: ignore[index]
    assert found["looks"].dtype == np.float32  # type: ignore[attr-defined]
    assert made.anew


def test_only_what_dataclasses_of_the_room_hold_is_read(tmp_path: Path) -> None:
    from elastomorph.errors import FormatError
    from elastomorph.io.npz.members import write_arrays

    layouts = (
        '["object", "pathlib", "Path", {}]',
        '["object", "os", "system", {}]',
        "[",
        '["x", 1]',
    )
    for layout in layouts:
        write_arrays(tmp_path / "a.npz", {"layout": np.array(layout)})
        with pytest.raises(FormatError, match="holds no result of a stage"):
            Made(tmp_path / "a.npz", "", 0.0, False).read()


def chain(
    working: WorkingFolder, made: list[str], first: object = 1, second: object = 1
) -> Made[int]:
    """Three stages, of which the last two depend on the first's result."""

    def making(name: str, value: int) -> int:
        made.append(name)
        return value

    a = working.made("a", {"option": first}, lambda: making("a", abs(first)), "1")
    b = working.made(
        "b",
        {"a": a.digest, "option": second},
        lambda: making("b", a.read() + second),
        "1",
    )
    return working.made("c", {"b": b.digest}, lambda: making("c", 2 * b.read()), "1")


def test_what_changed_and_what_depends_on_it_is_made_again(tmp_path: Path) -> None:
    made: list[str] = []
    with WorkingFolder(tmp_path) as working:
        assert chain(working, made).read() == 4
        assert made == ["a", "b", "c"]
        again = chain(working, made)
        assert (again.read(), again.anew, made) == (4, False, ["a", "b", "c"])
        assert chain(working, made, second=5).read() == 12
        assert made[3:] == ["b", "c"]
        assert chain(working, made, first=3, second=5).read() == 16
        assert made[5:] == ["a", "b", "c"]
        # Made again with the same result, nothing behind it is.
        assert chain(working, made, first=-3, second=5).read() == 16
        assert made[8:] == ["a"]


def test_another_version_is_made_again(tmp_path: Path) -> None:
    with WorkingFolder(tmp_path) as working:
        working.made("a", {}, lambda: 1, "one")
        assert working.made("a", {}, lambda: 2, "other").read() == 2


@pytest.mark.parametrize("damage", ["cut", "flipped", "empty", "text"])
def test_what_is_damaged_is_made_again(tmp_path: Path, damage: str) -> None:
    with WorkingFolder(tmp_path) as working:
        value = np.arange(1000)
        file = working.made("a", {}, lambda: value, 1).file
        content = bytearray(file.read_bytes())
        if damage == "cut":
            content = content[: len(content) // 2]
        elif damage == "flipped":
            content[content.index(np.arange(500, 504).tobytes())] ^= 1
        else:
            content = bytearray(b"" if damage == "empty" else b"not an archive")
        file.write_bytes(content)
        again = working.made("a", {}, lambda: value, 1)
        assert again.anew
        np.testing.assert_array_equal(again.read(), value)


PROGRAM = """
import sys, time
import numpy as np
from pathlib import Path
from elastomorph.capturing.work.stages import WorkingFolder
with WorkingFolder(Path(sys.argv[1])) as working:
    for name in "abcdefgh":
        def make():
            print(name, flush=True)
            time.sleep(float(sys.argv[2]))
            return np.full(300_000, ord(name))
        working.made(name, {}, make, 1)
"""


def test_a_second_process_is_refused_and_the_end_of_the_first_lets_it_in(tmp_path: Path) -> None:
    with started("-c", PROGRAM, str(tmp_path), "60", stdout=-1) as other:
        assert other.stdout is not None
        other.stdout.readline()  # it has the folder
        with (
            pytest.raises(FileError, match="another process is working in this folder"),
            WorkingFolder(tmp_path),
        ):
            pass
        other.send_signal(signal.SIGKILL)
        other.wait()
    with WorkingFolder(tmp_path) as working:
        assert working.made("a", {}, lambda: 1, 1).read() == 1


def test_two_works_of_one_process_are_kept_apart_too(tmp_path: Path) -> None:
    with (
        WorkingFolder(tmp_path),
        pytest.raises(FileError, match="another process"),
        WorkingFolder(tmp_path),
    ):
        pass


@pytest.mark.slow
def test_whatever_moment_a_process_is_killed_at_finished_stages_are_kept_and_whole(
    tmp_path: Path,
) -> None:
    """Killed a quarter later each time, until one comes to the end, however busy the machine is."""
    finished = 0
    for round_ in range(40):
        with started("-c", PROGRAM, str(tmp_path), "0.02", stdout=-1) as child:
            assert child.stdout is not None
            made = [child.stdout.readline().strip()]
            if made == [""]:
                break
            time.sleep(0.004 * 1.25**round_)
            child.send_signal(signal.SIGKILL)
            made += child.stdout.read().split()
        # It began with the first that was not finished, and made each after it.
        assert "abcdefgh".index(made[0]) == finished
        files = sorted(file for file in tmp_path.glob("*.npz") if not file.name.startswith("."))
        finished = len(files)
        for file in files:
            value = Made(file, "", 0.0, anew=False).read()
            assert (value == ord(file.stem)).all()
        if finished == 8:
            break
    assert finished == 8
    with WorkingFolder(tmp_path) as working:
        working.made("last", {}, lambda: 1, 1)
    assert not list(tmp_path.glob(".elastomorph-*"))  # what the killed ones left half written


FULL = """
import resource, sys
import numpy as np
from pathlib import Path
from elastomorph.capturing.work.stages import WorkingFolder
from elastomorph.errors import ElastomorphError
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
try:
    with WorkingFolder(Path(sys.argv[1])) as working:
        working.made("small", {}, lambda: np.zeros(1000), 1)
        working.made("large", {}, lambda: np.zeros(100_000), 1)
except ElastomorphError as error:
    print(error)
"""


def test_where_the_disk_is_full_finished_stages_are_kept(tmp_path: Path) -> None:
    """A file that may not grow any further stands for a disk that has no more room."""
    with started("-c", FULL, str(tmp_path), stdout=-1) as child:
        said = child.communicate()[0]
    assert said == (
        f"{tmp_path}: the disk is full; what was finished is kept: make room and run the same "
        "command again\n"
    )
    assert {file.name for file in tmp_path.iterdir()} == {".lock", "small.npz"}
