"""Whatever becomes of the FBX worker, the program that started it gets a rig or one clear error."""

from __future__ import annotations

import importlib.util
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pytest
from fbx_samples import as_binary, as_text, quad, scene

from elastomorph.errors import FileError, FormatError
from elastomorph.io.fbx import process, read_fbx
from elastomorph.rig import Rig

if importlib.util.find_spec("ufbx") is None:
    pytest.skip("ufbx is not installed: pip install 'elastomorph[fbx]'", allow_module_level=True)

SLOWEST = 20.0


@pytest.fixture
def face(tmp_path: Path) -> Path:
    path = tmp_path / "face.fbx"
    path.write_bytes(as_binary(scene(quad())))
    return path


def outcome(path: Path) -> Rig | FormatError:
    """The rig or the refusal; anything else, or a long wait, is a failure."""
    start = time.perf_counter()
    try:
        found: Rig | FormatError = read_fbx(path)
    except FormatError as error:
        if str(path) not in str(error):
            raise
        found = error
    assert time.perf_counter() - start < SLOWEST
    return found


def use_worker(monkeypatch: pytest.MonkeyPatch, folder: Path, code: str) -> None:
    worker = folder / "another_worker.py"
    worker.write_text(code)
    monkeypatch.setattr(process, "_WORKER", worker)


@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", "SIGSEGV"),
        ("import os; os.abort()", "SIGABRT"),
        ("import sys; sys.exit(7)", "exit status 7"),
        ("pass", "exit status 0"),
        ("raise AttributeError('no such thing')", "AttributeError: no such thing"),
        (
            "import sys; sys.stderr.write('Bad header'); sys.exit(3)",
            r"cannot be read as FBX \(Bad header\)",
        ),
        ("import sys; open(sys.argv[2], 'wb').write(b'PK')", "content makes no sense: this is not"),
        ("import sys, numpy; numpy.savez(sys.argv[2], a=1)", "there is no array 'axes'"),
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_a_worker_that_breaks_becomes_one_error_that_says_what_to_do(
    face: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, code: str, words: str
) -> None:
    use_worker(monkeypatch, tmp_path, code)
    with pytest.raises(FormatError, match=words) as caught:
        read_fbx(face)
    assert str(caught.value).startswith(f"{face}: ")
    assert "export it again" in str(caught.value)


def test_a_worker_that_hangs_is_stopped(
    face: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    use_worker(monkeypatch, tmp_path, "import time; time.sleep(60)")
    monkeypatch.setattr(process, "_SECONDS", 0.3)
    start = time.perf_counter()
    with pytest.raises(FormatError, match="longer than 0 seconds and was stopped"):
        read_fbx(face)
    assert time.perf_counter() - start < 10


@pytest.mark.skipif(sys.platform != "linux", reason="the limit on memory is that of Linux")
def test_a_worker_that_wants_too_much_memory_is_refused(
    face: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """NumPy alone maps more than this, so that the limit is seen to be in force."""
    monkeypatch.setattr(process, "_BYTES", 1 << 20)
    monkeypatch.setattr(process, "_EXPANSION", 0)
    with pytest.raises(FormatError, match=r"broke on it|more memory|cannot be read"):
        read_fbx(face)


def test_nothing_is_left_behind(
    face: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    read_fbx(face)
    face.write_bytes(b"no FBX")
    with pytest.raises(FormatError):
        read_fbx(face)
    assert list(scratch.iterdir()) == []


def test_an_interpreter_that_does_not_know_itself_is_no_mystery(
    face: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "")
    with pytest.raises(FileError, match="does not know its interpreter"):
        read_fbx(face)


@pytest.mark.parametrize(
    "content", [b"", b"text", b"; FBX 7.4.0 project file\n", b"Kaydara FBX Binary  \x00\x1a\x00"]
)
def test_what_is_no_fbx_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.fbx"
    path.write_bytes(content)
    assert isinstance(outcome(path), FormatError)


@pytest.mark.parametrize("encoding", [as_text, as_binary])
def test_a_file_cut_off_anywhere(tmp_path: Path, encoding: object) -> None:
    """A sample of lengths: text may be cut to a shorter whole text, binary may not."""
    whole = (as_text if encoding is as_text else as_binary)(scene(quad()))
    path = tmp_path / "a.fbx"
    for length in np.linspace(1, len(whole) - 200, 12).astype(int).tolist():
        path.write_bytes(whole[:length])
        found = outcome(path)
        assert encoding is as_text or isinstance(found, FormatError)


@pytest.mark.parametrize("encoding", [as_text, as_binary])
def test_a_file_with_bytes_changed_anywhere(tmp_path: Path, encoding: object) -> None:
    whole = (as_text if encoding is as_text else as_binary)(scene(quad()))
    random = np.random.default_rng(11)
    path = tmp_path / "a.fbx"
    for _ in range(14):
        changed = bytearray(whole)
        for place in random.integers(30, len(whole), size=random.integers(1, 4)).tolist():
            changed[place] = int(random.integers(256))
        path.write_bytes(changed)
        outcome(path)


def test_points_and_shapes_that_contradict_each_other(tmp_path: Path) -> None:
    """Indices beyond the points, numbers that are not finite: refused, or as the reader mends."""
    whole = as_text(scene(quad()))
    path = tmp_path / "a.fbx"
    for old, new in [
        (b"a: 0,1,2,-4", b"a: 0,1,2,-400"),
        (b"a: 2\n", b"a: 99\n"),
        (b"a: 2\n", b"a: -5\n"),
        (b"0.25,0.5", b"1e999,0.5"),
        (b"0.0,0.0,0.5", b"nan,0.0,0.5"),
        (b'"Lcl Scaling", "", "A", 1.0', b'"Lcl Scaling", "", "A", 1e400'),
    ]:
        assert whole.count(old) == 1
        path.write_bytes(whole.replace(old, new))
        found = outcome(path)
        if isinstance(found, Rig):
            assert np.isfinite(found.pose({"lift": 1.0})).all()


def test_the_worker_leaves_no_core_and_no_output_of_its_own(
    face: Path, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    here = Path.cwd()
    os.chdir(tmp_path)
    try:
        read_fbx(face)
    finally:
        os.chdir(here)
    assert capfd.readouterr() == ("", "")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["face.fbx"]
