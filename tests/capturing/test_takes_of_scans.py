"""Takes of scans as a user registers them: stopped, killed and long."""

from __future__ import annotations

import os
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

import elastomorph as em
from children import started
from elastomorph.errors import ElastomorphWarning
from needs import extra

extra("embreex", "capture")
extra("cv2", "capture")

from small_masks import mask_rig, write_take  # noqa: E402
from small_scans import in_single_steps  # noqa: E402

from elastomorph.capturing.landmarks import read_landmarks  # noqa: E402
from elastomorph.capturing.scans import registered_files, registration  # noqa: E402
from elastomorph.capturing.work.registered import Registered  # noqa: E402
from elastomorph.io.npz.confidence import read_confidence  # noqa: E402

pytestmark = pytest.mark.photographs

THREE = [{}, {"jaw": 0.4}, {"jaw": 0.8, "smile": 0.5}]


def process(folder: Path, words: list[str], output: str):
    return started(
        *("-m", "elastomorph", *words, "-o", output, "--no-report"),
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env=os.environ | {"PYTHONDONTWRITEBYTECODE": "1"},
    )


@pytest.fixture(scope="module")
def take(tmp_path_factory) -> tuple[Path, list[str]]:
    """Three scans, registered into the folder ``whole`` by a process that nobody stopped."""
    folder = tmp_path_factory.mktemp("take")
    words = write_take(folder, THREE)
    with process(folder, words, "whole") as running:
        said = running.communicate()[1]
    assert running.returncode == 0, said
    return folder, words


@pytest.mark.skipif(os.name != "posix", reason="needs POSIX signals")
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_a_process_that_is_stopped_in_the_third_scan_goes_on_there(take, number) -> None:
    folder, words = take
    output = signal.Signals(number).name
    with process(folder, words, output) as running:
        for line in running.stderr:
            if line.endswith("2 of 3\n"):
                break
        running.send_signal(number)
        said = running.stderr.read()
        running.wait()
    there = {path.name for path in (folder / output).iterdir()}
    assert {"frame000.obj", "frame001.obj"} <= there
    assert "frame002.obj" not in there
    if number == signal.SIGKILL:
        assert running.returncode == -number
    else:
        assert running.returncode == 128 + number
        assert said == (
            f"interrupted: 2 of 3 poses are in {output}; the same command goes on from there\n"
        )
        assert there == {"frame000.obj", "frame001.obj", "confidence.npz", "register.json"}
    finished = {path: path.stat().st_mtime_ns for path in (folder / output).glob("*.obj")}
    with process(folder, words, output) as running:
        said = running.communicate()[1]
    assert running.returncode == 0, said
    assert {path: path.stat().st_mtime_ns for path in finished} == finished
    files = sorted(path.name for path in (folder / "whole").iterdir())
    assert files == sorted(path.name for path in (folder / output).iterdir())
    for name in files:
        assert (folder / output / name).read_bytes() == (folder / "whole" / name).read_bytes(), name


def test_figures_of_a_long_take_are_written_once(tmp_path, monkeypatch) -> None:
    """And not at each pose with those of all before it."""
    in_single_steps(monkeypatch)
    weights = [{"jaw": 0.5 - 0.5 * float(np.cos(k))} for k in range(8)]
    scans = write_take(tmp_path, weights)[1:-4]
    times, write = [], registered_files.write_confidence
    monkeypatch.setattr(
        registered_files, "write_confidence", lambda *a: times.append(len(a[1])) or write(*a)
    )
    begun, following = [], registration._next

    def noted(person, scan, marks, pose, say):
        begun.append(pose.figures["scan"])
        return following(person, scan, marks, pose, say)

    monkeypatch.setattr(registration, "_next", noted)
    marks = read_landmarks(tmp_path / "marks.json")
    with pytest.warns(ElastomorphWarning):
        poses = em.register_all(
            [tmp_path / scan for scan in scans], mask_rig(), landmarks=marks, output=tmp_path / "p"
        )
    assert times == [8]
    assert begun == scans[:-1]
    assert set(read_confidence(tmp_path / "p" / "confidence.npz")) == set(poses)
    assert not (tmp_path / "p" / ".register").exists()


def test_a_long_take_in_which_heads_are_doubted_warns_of_them_once() -> None:
    mesh = mask_rig().neutral
    figures = {"correspondence": registration.BY_SURFACE}
    poses = {
        f"frame{k}": Registered.of(
            mesh,
            mesh.vertices,
            np.ones(len(mesh.vertices)),
            figures | {"head": {"doubt_degrees": k, "doubt_mean": 0.2 * k}},
        )
        for k in range(5)
    }
    with pytest.warns(ElastomorphWarning) as said:
        registration._warn(poses)
    heads, along = [str(own.message) for own in said]
    assert heads.startswith("frame4: its head may be turned by 4.0° otherwise, which moves skin by")
    assert "0.80 % of D, and those of 2 more by less: too little" in heads
    assert along.startswith("frame0 and 4 more: correspondence")
