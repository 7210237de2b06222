"""``elastomorph render`` from the command line to the files."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from calls import status_of as run
from PIL import Image, ImageSequence

import elastomorph as em
from children import started
from needs import extra
from small_head import expressions, head

SMALL = ("--size", "96x120")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of meshes and a rig file of the same shapes."""
    place = tmp_path_factory.mktemp("rig")
    em.write(place / "neutral.obj", head())
    em.write(place / "smile.obj", expressions()["grinning"])
    em.write(place / "sad.obj", expressions()["sad"])
    return place


@pytest.fixture(scope="module")
def rig_file(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("file") / "rig.npz"
    em.write(path, em.read_rig(folder))
    return path


def _pixels(path: Path) -> np.ndarray:
    with Image.open(path) as image:
        return np.asarray(image).astype(int)


def test_a_picture_of_a_pose(
    rig_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """t scales the weights: smile=1 at t = 0.5 is smile=0.5, and neither is the neutral."""
    words = [("smile=1", 0.5), ("smile=0.5,sad=0", 1), ("smile=1", 0), ("smile=1", 1)]
    images = []
    for number, (pose, t) in enumerate(words):
        out = tmp_path / f"{number}.png"
        assert run("render", rig_file, "--pose", pose, "--t", t, *SMALL, "-o", out, "--json") == 0
        facts = json.loads(capsys.readouterr().out)
        assert facts["written"] == str(out)
        assert (facts["width"], facts["height"]) == (96, 120)
        images.append(_pixels(out))
    assert images[0].shape == (120, 96, 3)
    assert np.abs(images[0] - images[1]).mean() < 0.5  # the cameras make room for other paths
    still, smile = np.abs(images[2] - images[0]), np.abs(images[3] - images[0])
    assert still.mean() > 0.3
    assert smile.mean() > 0.3


def test_a_folder_and_its_rig_file_look_the_same(
    folder: Path, rig_file: Path, tmp_path: Path
) -> None:
    for name, rig in (("a.png", folder), ("b.png", rig_file)):
        assert run("render", rig, "-p", "smile=0.8", *SMALL, "-o", tmp_path / name) == 0
    difference = np.abs(_pixels(tmp_path / "a.png") - _pixels(tmp_path / "b.png"))
    assert difference.mean() < 0.05


def test_a_plain_mesh_against_another(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "heat.png"
    meshes = (folder / "smile.obj", "--against", folder / "neutral.obj")
    assert run("render", *meshes, "--size", "240x300", "-o", out, "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    moved = np.linalg.norm(expressions()["grinning"].vertices - head().vertices, axis=1)
    assert facts["distance"]["largest"] == pytest.approx(moved.max(), rel=1e-6)
    assert facts["distance"]["mean"] == pytest.approx(moved.mean(), rel=1e-6)
    assert _pixels(out).shape == (300, 240, 3)


def test_a_mesh_in_an_archive(tmp_path: Path) -> None:
    em.write(tmp_path / "mesh.npz", head())
    assert run("render", tmp_path / "mesh.npz", *SMALL, "-o", tmp_path / "a.jpg") == 0
    assert _pixels(tmp_path / "a.jpg").shape == (120, 96, 3)


def test_a_method_measured_against_another(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """At t = 1 straight and eased paths are at the same place; half way they are not."""
    largest = []
    for t in (1, 0.5):
        words = ("-p", "smile=1", "-t", t, "--method", "ease:2", "--against", "linear")
        out = ("-o", tmp_path / "a.png", "--json")
        assert run("render", folder, *words, *SMALL, "--edge-loops", *out) == 0
        largest.append(json.loads(capsys.readouterr().out)["distance"]["largest"])
    assert largest[0] == pytest.approx(0, abs=1e-9)
    assert largest[1] > 0.01


def test_a_strip_with_a_row_for_each_method(folder: Path, tmp_path: Path) -> None:
    one, two = tmp_path / "one.png", tmp_path / "two.png"
    words = ("-p", "smile=1", "--strip", "0,0.5,1", "--size", "48x60")
    assert run("render", folder, *words, "-o", one) == 0
    methods = ("--method", "linear", "--method", "beam:2")
    assert run("render", folder, *words, *methods, "-o", two) == 0
    assert _pixels(one).shape[1] >= 3 * 48
    assert len(_pixels(two)) >= len(_pixels(one)) + 60


def test_clips(rig_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    turn, smile, frame = tmp_path / "t.gif", tmp_path / "s.webp", tmp_path / "f.##.png"
    common = ("-p", "smile=1", "--frames", 6, *SMALL, "--json")
    assert run("render", rig_file, "--turntable", "--fps", 10, *common, "-o", turn) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["frames"], facts["fps"], facts["seconds"]) == (6, 10, 0.6)
    clear = ("--background", "transparent")
    assert run("render", rig_file, "--animate", *clear, *common, "-o", smile) == 0
    assert run("render", rig_file, "--animate", "--turntable", *common, "-o", frame) == 0
    for path in (turn, smile):
        with Image.open(path) as picture:
            assert picture.n_frames == 6
            assert picture.size == (96, 120)
    with Image.open(smile) as picture:
        frames = [np.asarray(each).astype(int) for each in ImageSequence.Iterator(picture)]
    assert frames[0].shape[2] == 4
    # there and back: 0, 1/3, 2/3, 1, 2/3, 1/3 of the way
    assert np.abs(frames[1] - frames[5]).mean() < np.abs(frames[1] - frames[3]).mean()
    assert len(list(tmp_path.glob("f.*.png"))) == 6


def test_a_movie(rig_file: Path, tmp_path: Path) -> None:
    imageio_ffmpeg = extra("imageio_ffmpeg", "demo")
    out = tmp_path / "turn.mp4"
    words = ("--turntable", "--frames", 8, "--fps", 12, *SMALL)
    assert run("render", rig_file, *words, "-o", out) == 0
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(out))
    assert frames == 8
    assert seconds == pytest.approx(8 / 12, abs=0.02)


@pytest.mark.skipif(os.name != "posix", reason="sends the signal of Ctrl-C")
def test_ctrl_c_leaves_nothing_behind(rig_file: Path, tmp_path: Path) -> None:
    extra("imageio_ffmpeg", "demo")
    words = ["render", str(rig_file), "--turntable", "--frames", "5000", *SMALL]
    words += ["-o", str(tmp_path / "a.mp4")]
    code = "import sys; from elastomorph.cli import main; main(sys.argv[1:])"
    with started("-c", code, *words, stderr=subprocess.PIPE) as process:
        until = time.monotonic() + 60
        while not list(tmp_path.iterdir()) and time.monotonic() < until:
            time.sleep(0.05)
        assert list(tmp_path.iterdir())
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
    assert process.returncode == 130
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-o", "a.tiff"], "found .tiff"),
        (["-o", "a"], "no suffix"),
        (["-o", "a.mp4"], "--turntable"),
        (["-o", "a.##.png"], "--turntable"),
        (["-o", "a.txt", "--turntable"], ".mp4"),
        (["-o", "a.png", "-p", "smlie=1"], "did you mean 'smile'"),
        (["-o", "a.png", "-p", "smile"], "name=number"),
        (["-o", "a.png", "-p", "smile=inf"], "finite"),
        (["-o", "a.png", "-p", "smile=1", "-t", "nan"], "finite"),
        (["-o", "a.png", "--size", "0x0"], "from 16 to 4096"),
        (["-o", "a.png", "--size", "90000x90000"], "from 16 to 4096"),
        (["-o", "a.png", "--size", "wide"], "720x900"),
        (["-o", "a.mp4", "--turntable", "--size", "33x40"], "34x40"),
        (["-o", "a.mp4", "--turntable", "--frames", "0"], "at least 1 frame"),
        (["-o", "a.mp4", "--turntable", "--degrees", "0"], "other than 0"),
        (["-o", "a.mp4", "--turntable", "--view", "eyes"], "close-up"),
        (["-o", "a.gif", "--turntable", "--fps", "60"], "50 frames"),
        (["-o", "a.mp4", "--animate"], "nothing would move"),
        (["-o", "a.png", "--strip", "0,x", "-p", "sad=1"], "--strip"),
        (["-o", "a.png", "--strip", "0,1", "--turntable"], "not both"),
        (["-o", "a.png", "--frames", "3"], "clips"),
        (["-o", "a.png", "--timing", "blink"], "--animate"),
        (["-o", "a.png", "--degrees", "90"], "--turntable"),
        (["-o", "a.png", "--highest", "1"], "--against"),
        (["-o", "a.png", "--method", "linear", "--method", "arc"], "--strip"),
        (["-o", "a.png", "--strip", "1", "-p", "sad=1", *["--method", "arc"] * 2], "twice"),
        (["-o", "a.png", "--view", "top"], "three-quarter"),
        (["-o", "a.png", "--view", "0,90"], "below 90"),
        (["-o", "a.png", "--background", "blurple"], "blurple"),
        (["-o", "a.jpg", "--background", "transparent"], "PNG and WebP"),
        (["-o", "a.png", "--background", "transparent", "--against", "linear"], "paper"),
        (["-o", "a.png", "--against", "linaer"], "neither a file nor a method"),
        (["-o", "a.png", "--against", "other.obj"], "other.obj"),
        (["-o", "nowhere/a.png"], "nowhere"),
        (["-o", "nowhere/a.mp4", "--turntable"], "nowhere"),
        (["-o", "a.png", "gone.glb"], "gone.glb"),
    ],
)
def test_mistakes_in_one_sentence(
    words: list[str],
    message: str,
    rig_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    size = [] if "--size" in words else list(SMALL)
    rig = [] if "gone.glb" in words else [rig_file]
    assert run("render", *rig, *words, *size) == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ")
    assert message in said
    assert said.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_mesh_has_nothing_to_pose(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ("render", folder / "smile.obj", "-p", "smile=1", "-o", tmp_path / "a.png")
    assert run(*words) == 1
    assert "without sliders" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
