"""Whatever becomes of a worker, the program that started it gets its arrays or one clear error."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from effort import worked
from elastomorph.errors import FileError, FormatError
from elastomorph.io import isolated
from elastomorph.io.isolated import IsolatedReader, RefusedError, allow_for, extracted

posix = pytest.mark.skipif(os.name != "posix", reason="needs signals")
linux = pytest.mark.skipif(sys.platform != "linux", reason="the limits are those of Linux")

BEGINNING = """
import os, signal, sys, time
import numpy as np
from elastomorph.io.isolated import RefusedError, allow_for, serve

def content(source, *arguments):
    {code}

if __name__ == "__main__":
    serve(lambda: None, content)
"""

Made = Callable[[str], IsolatedReader]


@pytest.fixture
def worker(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Made:
    """Makes a worker whose content comes from some lines of code."""

    def made(code: str) -> IsolatedReader:
        folder = tmp_path / "modules"
        folder.mkdir(exist_ok=True)
        lines = code.strip().replace("\n", "\n    ")
        (folder / "worker_of_a_test.py").write_text(BEGINNING.format(code=lines))
        monkeypatch.syspath_prepend(str(folder))
        return IsolatedReader("worker_of_a_test", "the reader of toys", "buy another one")

    return made


@pytest.fixture
def toy(tmp_path: Path) -> Path:
    path = tmp_path / "a toy.file"
    path.write_bytes(b"toy")
    return path


def refusal(reader: IsolatedReader, path: Path) -> str:
    """The message of the one error; the file is named once and nothing temporary."""
    with pytest.raises(FormatError) as caught, extracted(reader, path):
        pass
    message = str(caught.value)
    assert message.startswith(f"{path}: ")
    assert f"{tempfile.gettempdir()}/elastomorph-" not in message
    return message.removeprefix(f"{path}: ")


def test_arrays_come_as_the_worker_made_them(worker: Made, toy: Path) -> None:
    reader = worker(
        "return {'size': np.array(os.path.getsize(source)), 'words': np.array(arguments)}"
    )
    with extracted(reader, toy, "one", "two") as members:
        assert members.names == {"size", "words"}
        assert int(members.array("size", "i", ())) == 3
        assert members.array("words", "U", (2,)).tolist() == ["one", "two"]


def test_a_refusal_is_told_in_the_words_of_the_worker(worker: Made, toy: Path) -> None:
    assert refusal(worker("raise RefusedError('it has no wheels')"), toy) == "it has no wheels"


def test_a_long_refusal_is_cut(worker: Made, toy: Path) -> None:
    assert len(refusal(worker("raise RefusedError('x' * 1_000_000)"), toy)) == 2000


@posix
@pytest.mark.parametrize(
    ("code", "words"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", "broke while reading it (SIGSEGV)"),
        ("os.abort()", "broke while reading it (SIGABRT)"),
        ("os._exit(7)", "broke while reading it (exit status 7)"),
        ("os._exit(0)", "broke while reading it (exit status 0)"),
        ("os._exit(3)", "broke while reading it (exit status 3)"),
        ("raise AttributeError('no such thing')", "(AttributeError: no such thing)"),
        ("raise SystemExit(0)", "(SystemExit: 0)"),
        ("return {'a': np.array([None])}", "(ValueError: Object arrays cannot be saved"),
        (
            "open(sys.argv[1] + '/arrays.npz', 'wb').write(b'PK')\nos._exit(0)",
            "its content makes no sense: this is not an intact archive",
        ),
    ],
)
def test_a_worker_that_breaks_is_one_error_that_says_what_to_do(
    worker: Made, toy: Path, code: str, words: str
) -> None:
    message = refusal(worker(code), toy)
    assert words in message
    assert message.endswith("; buy another one")


def test_arrays_that_are_not_those_asked_for_are_an_error_of_the_file(
    worker: Made, toy: Path
) -> None:
    reader = worker("return {'points': np.zeros(5)}")
    with (
        pytest.raises(
            FormatError, match=r"makes no sense: the array 'points' has the shape"
        ) as why,
        extracted(reader, toy) as members,
    ):
        members.array("points", "f", (None, 3))
    assert str(why.value).startswith(f"{toy}: ")


def test_errors_of_the_one_who_asks_pass_through(worker: Made, toy: Path) -> None:
    reader = worker("return {}")
    with pytest.raises(FileError, match="another"), extracted(reader, toy):
        raise FileError("another.file", "is missing")
    with pytest.raises(ZeroDivisionError), extracted(reader, toy):
        1 / 0  # noqa: B018


@posix
def test_a_worker_that_computes_without_end_is_stopped(worker: Made, toy: Path) -> None:
    """By its processor time: the limits of `isolated` are about two seconds for a small file."""
    before = worked()
    message = refusal(worker("while True: pass"), toy)
    assert "(SIGPROF, too much time)" in message
    assert worked() - before < 15


def test_a_worker_that_waits_without_end_is_stopped(
    worker: Made, toy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(isolated, "_WAIT", 1.5)
    start = time.monotonic()
    message = refusal(worker("time.sleep(600)"), toy)
    assert "did not finish reading it within 2 s" in message
    assert time.monotonic() - start < 600


@linux
def test_a_worker_that_wants_too_much_memory_is_refused(worker: Made, toy: Path) -> None:
    """A file of three bytes may take some 64 MiB beyond what the libraries take."""
    message = refusal(worker("return {'a': np.ones(20 << 20)}"), toy)
    assert message == "it needs more memory than a file of its size should"


@linux
def test_a_larger_file_may_take_more_memory(worker: Made, toy: Path) -> None:
    with toy.open("r+b") as file:
        file.truncate(1_000_000)
    reader = worker("np.ones(20 << 20)\nreturn {'a': np.zeros(1)}")
    with extracted(reader, toy) as members:
        assert members.names == {"a"}


@linux
def test_another_file_that_must_be_read_too_counts(worker: Made, toy: Path) -> None:
    reader = worker("allow_for(1_000_000)\nnp.ones(20 << 20)\nreturn {}")
    with extracted(reader, toy) as members:
        assert members.names == frozenset()


def test_a_process_without_limits_gets_none(toy: Path) -> None:
    """Where content is made without a process of its own, nothing is limited afterwards."""
    allow_for(10)
    end = time.process_time() + 0.2
    while time.process_time() < end:
        pass


@linux
def test_a_worker_cannot_fill_the_disk(worker: Made, toy: Path) -> None:
    """One block of memory written again and again: small in memory, endless in the archive."""
    reader = worker("return {'a': np.broadcast_to(np.zeros(1 << 20), (1000, 1 << 20))}")
    assert "broke while reading it" in refusal(reader, toy)
    noisy = worker("while True: sys.stderr.write('x' * 1_000_000)")
    assert "broke while reading it" in refusal(noisy, toy)


def test_arrays_that_take_too_much_memory_here_are_refused(worker: Made, toy: Path) -> None:
    reader = worker("return {'a': np.zeros(2 << 20)}")
    with (
        pytest.raises(FormatError, match="would take more memory than") as caught,
        extracted(reader, toy) as members,
    ):
        members.array("a", "f", (None,))
    assert str(caught.value).startswith(f"{toy}: ")


def test_nothing_is_left_behind(
    worker: Made, toy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    with extracted(worker("return {}"), toy):
        assert len(list(scratch.iterdir())) == 1
    refusal(worker("raise RefusedError('no')"), toy)
    refusal(worker("os.abort()"), toy)
    assert list(scratch.iterdir()) == []


def test_a_worker_prints_nothing(
    worker: Made, toy: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with extracted(worker("print('hello'); sys.stderr.write('hello'); return {}"), toy):
        pass
    assert capfd.readouterr() == ("", "")


def test_modules_of_the_current_folder_are_not_taken_for_ours(
    worker: Made, toy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file from a stranger may lie in a folder with a numpy.py."""
    reader = worker("return {}")
    trap = tmp_path / "trap"
    trap.mkdir()
    for name in ("numpy", "json", "ufbx", "elastomorph"):
        (trap / f"{name}.py").write_text("raise SystemExit('trapped')")
    monkeypatch.chdir(trap)
    with extracted(reader, toy) as members:
        assert members.names == frozenset()


def test_an_interpreter_that_does_not_know_itself_is_no_mystery(
    worker: Made, toy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reader = worker("return {}")
    monkeypatch.setattr(sys, "executable", "")
    with pytest.raises(FileError, match="does not know its interpreter"), extracted(reader, toy):
        pass
    monkeypatch.setattr(sys, "executable", str(toy))
    with pytest.raises(FileError, match="no process could be started"), extracted(reader, toy):
        pass


def test_a_file_that_is_not_there_starts_nothing(tmp_path: Path) -> None:
    reader = IsolatedReader("no.such.module", "nobody", "nothing")
    with pytest.raises(FileError, match="no such file"), extracted(reader, tmp_path / "gone"):
        pass


def test_a_module_that_is_no_worker_is_an_error(toy: Path) -> None:
    message = refusal(IsolatedReader("no_such_module_at_all", "nobody", "nothing"), toy)
    assert "No module named no_such_module_at_all" in message


def test_a_refusal_is_an_exception_of_workers_only() -> None:
    """It never leaves `extracted`, and so is none of the errors people catch."""
    assert not issubclass(RefusedError, FileError)
    assert np.array_equal(RefusedError("a").args, ["a"])
