"""Commands that cannot finish: full disks, interrupts and kills leave whole files or none."""

from __future__ import annotations

import importlib.util
import os
import random
import signal
import subprocess
import sys
import time
from contextlib import AbstractContextManager
from pathlib import Path
from types import ModuleType

import pytest
from calls import status_of

from children import started
from small_head import rig_file

pytestmark = pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals and limits")

HEAD = "HEAD"  # stands for the file of the small head, which is written when it is first needed
ONLY = ("--only", "jawOpen")
WRITING = [
    ("export", HEAD, *ONLY, "-o", "face.glb"),
    ("export", HEAD, *ONLY, "-o", "face.npz"),
    ("export", HEAD, *ONLY, "-o", "face.usda"),
    ("export", HEAD, *ONLY, "-o", "face.usdc"),
    ("blend", HEAD, "--levels", "2", "-o", "face.npy"),
    ("bench", HEAD, "--levels", "2", "--json"),
]


def running(
    words: tuple[str, ...], folder: Path, most_bytes: int | None = None, **files: object
) -> AbstractContextManager[subprocess.Popen[str]]:
    """A command in a process of its own, whose files may be no longer than some bytes."""
    limit = f"resource.setrlimit(resource.RLIMIT_FSIZE, ({most_bytes}, {most_bytes}))"
    program = (
        f"import resource\n{limit if most_bytes is not None else ''}\n"
        "from elastomorph.cli import main\nmain()"
    )
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    named = [str(rig_file()) if word == HEAD else word for word in words]
    return started("-c", program, *named, cwd=folder, env=environment, **files)


@pytest.mark.parametrize("stream", ["stdin", "stdout", "stderr"])
@pytest.mark.parametrize("word", ["--version", "nothing"])
def test_streams_may_be_closed(monkeypatch: pytest.MonkeyPatch, stream: str, word: str) -> None:
    """As for a service: Python then has None in their place."""
    monkeypatch.setattr(sys, stream, None)
    assert status_of(word) == (0 if word == "--version" else 2)


@pytest.mark.parametrize("words", WRITING[:5], ids=lambda words: words[-1])
def test_a_disk_that_is_full_midway_leaves_the_old_file(
    tmp_path: Path, words: tuple[str, ...]
) -> None:
    face = tmp_path / words[-1]
    face.write_bytes(b"the old file")
    files = {"stderr": subprocess.PIPE, "stdout": subprocess.DEVNULL}
    with running(words, tmp_path, 20_000, **files) as process:
        said = process.communicate()[1]
    assert process.returncode == 1, said
    assert said.startswith("error: ")
    assert len(said.splitlines()) == 1
    assert words[-1] in said
    assert face.read_bytes() == b"the old file"
    assert list(tmp_path.iterdir()) == [face]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("words", [("--help",), WRITING[5]], ids=["help", "json"])
def test_output_that_cannot_be_written_is_an_error(tmp_path: Path, words: tuple[str, ...]) -> None:
    with (
        Path("/dev/full").open("wb") as full,
        running(words, tmp_path, stdout=full, stderr=subprocess.PIPE) as process,
    ):
        said = process.communicate()[1]
    assert process.returncode == 1
    assert said.startswith("error: the output: ")
    assert "Traceback" not in said


@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 128 + signal.SIGTERM)]
)
def test_an_interrupt_leaves_nothing(tmp_path: Path, number: int, status: int) -> None:
    """The command is stopped as soon as its temporary file is there."""
    words = ("blend", HEAD, "--levels", "7", "-o", "faces.npy")
    patience = time.monotonic() + 60
    files = {"stderr": subprocess.PIPE, "stdout": subprocess.DEVNULL}
    with running(words, tmp_path, **files) as process:
        while not any(tmp_path.iterdir()) and process.poll() is None:
            assert time.monotonic() < patience
            time.sleep(0.005)
        process.send_signal(number)
        said = process.communicate()[1]
    assert process.returncode == status, said
    assert "Traceback" not in said
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(scope="module")
def kills() -> ModuleType:
    path = Path(__file__).parents[2] / "benchmarks" / "kills.py"
    spec = importlib.util.spec_from_file_location("kills", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["kills"] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("name", ["export head.glb", "export head.usdc", "interpolate frames"])
def test_a_kill_at_any_moment_leaves_whole_files(kills: ModuleType, name: str) -> None:
    found = kills.kill_again_and_again(kills.COMMANDS[name], 4, random.Random(name))
    assert (found.whole, found.broken, found.after) == (4, [], 0)
